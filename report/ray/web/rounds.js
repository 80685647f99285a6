// SPDX-License-Identifier: Apache-2.0
// Rounds, taken up as a whole when they are looked at: what lies where, and the lists, which only grow, with the event
// that wrote each entry.
import { apply, brings_hit, look_of, start_nodes } from './events.js';
import { gaussian_of } from './nodes.js';
import { Bytes, bytes_of, page, several } from './page.js';

const kSnapshot = 256; // events between two states that are kept

// The lists as a round begins.
const read_begin = (from, values) => {
  const list = (read) => Array.from({ length: from.number() }, read);
  const hit = () => ({ owner: from.number(), object: from.number(), gaussian: from.number(), t: from.time(values) });
  const entry = () => ({ node: from.number(), instance: from.number(), object: from.number(), t: from.time(values), depth: 0 });
  const begin = { k: list(hit), evictions: list(hit), source: list(entry), stack: list(entry), t_max: from.time(values) };
  start_nodes(from, begin.stack, begin.stack);
  return begin;
};

const note_event = (made, i, event, stack) => {
  made.node[i] = event.node;
  made.look[i] = look_of(event);
  made.depth[i] = event.depth;
  made.transforms[i] = event.transforms ? 1 : 0;
  if (event.hit !== null) {
    made.gaussian[i] = event.hit.gaussian;
    made.time[i] = event.hit.t;
  } else if (event.kind === 'instance') {
    const { object } = event.popped || stack[stack.length - 1];
    made.gaussian[i] = gaussian_of({ node: event.node, instance: event.node + 1, object });
  }
  if (event.read >= 0) made.read_at[event.read] = i;
  for (const entry of event.written) {
    made.destination.push(entry);
    made.destination_at.push(i);
  }
  if (event.evicted !== null && page.checkpoint) {
    made.evictions.push(event.evicted);
    made.evicted_at.push(i);
  }
  made.noted[i] = brings_hit(event) ? 2 : event.written.length > 0 && event.kind !== 'forward' ? 1 : 0;
};
const play_through = (made, state) => {
  let now = made.first_t_max;
  for (let i = 0; i < made.events; i += 1) {
    if (i % kSnapshot === 0) made.snapshots.push({ at: made.from.at, k: state.k.slice(), stack: state.stack.slice() });
    const event = apply(state, made.from, made.source, made.values);
    if (event.t_max !== undefined) now = event.t_max;
    made.t_max[i] = now;
    note_event(made, i, event, state.stack);
  }
};
// Where the part of the tree below each event ends, and the most that is noted in it. With several nodes under way what
// comes next need not be below: each event stands alone.
const find_subtrees = (made) => {
  const { events } = made;
  const above = [];
  for (let i = 0; i <= events; i += 1) {
    while (above.length > 0 && (several || i === events || made.depth[above[above.length - 1]] >= made.depth[i])) made.end[above.pop()] = i;
    above.push(i);
  }
  made.in_subtree = made.noted.slice();
  for (let i = events - 1; i >= 0; i -= 1) {
    for (let child = i + 1; child < made.end[i]; child = made.end[child])
      made.in_subtree[i] = Math.max(made.in_subtree[i], made.in_subtree[child]);
  }
};

const rounds = new Map();
export const all_taken_up = () => rounds.values();
export const forget_rounds = () => rounds.clear();
export const round_of = (of_ray, number) => {
  const id = `r${of_ray}_${number}`;
  if (rounds.has(id)) return rounds.get(id);
  const { values } = page.rays[of_ray];
  const { events } = page.rays[of_ray].rounds[number];
  const from = new Bytes(bytes_of(document.getElementById(id).textContent));
  const { k, evictions, source, stack, t_max } = read_begin(from, values);
  const made = {
    values,
    from,
    events,
    source,
    first_t_max: t_max,
    read_at: new Int32Array(source.length).fill(events),
    node: new Uint32Array(events),
    look: new Uint8Array(events),
    depth: new Uint16Array(events),
    transforms: new Uint8Array(events),
    t_max: new Float32Array(events),
    gaussian: new Uint32Array(events),
    time: new Float32Array(events),
    end: new Uint32Array(events),
    noted: new Uint8Array(events),
    destination: [],
    destination_at: [],
    evictions,
    evicted_at: evictions.map(() => -1),
    snapshots: [],
    open: new Set(), // what is unfolded
    rows: null,
  };
  play_through(made, { k, stack });
  find_subtrees(made);
  rounds.set(id, made);
  return made;
};

// The lists after event i of a round; -1: as the round begins. `event` is what event i did.
export const state_at = (round, i) => {
  if (round.events === 0) return { ...read_begin(new Bytes(round.from.bytes), round.values), event: null };
  const place = Math.floor(Math.max(i, 0) / kSnapshot),
    { at, k, stack } = round.snapshots[place],
    state = { k: k.slice(), stack: stack.slice() };
  let event = null;
  round.from.at = at;
  for (let e = place * kSnapshot; e <= i; e += 1) event = apply(state, round.from, round.source, round.values);
  return { ...state, event };
};
