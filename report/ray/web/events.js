// SPDX-License-Identifier: Apache-2.0
// What an event changes in the lists of a ray. packed_round.h says how it is written: which entry goes where stands
// there, so no rule of k-buffer or stack is known here.
import { gaussian_of, in_blas, nodes } from './nodes.js';
import { page, several } from './page.js';

// The looks of events: their kinds, and behind them the outcomes of leaf visits.
const kReads = ['internal', 'instance', 'leaf'];
export const looks = [
  ...page.kinds.map((name) => ({ name, reads: kReads.includes(name) })),
  ...page.outcomes.map((outcome) => ({ name: outcome.name, reads: true, outcome })),
];
export const look_of = (event) => (event.outcome === null ? event.kind_number : page.kinds.length + event.detail);
// Whether the event brought a hit for the k-buffer, be it that it did not stay there.
export const brings_hit = (event) => event.outcome !== null && (event.outcome.enters || event.outcome.evicts);

const begin_event = (first) => {
  const kind_number = first & 7,
    detail = (first >> 3) & 7,
    kind = page.kinds[kind_number];
  return {
    kind,
    kind_number,
    detail,
    outcome: kind === 'leaf' ? page.outcomes[detail] : null,
    transforms: kind === 'instance' && detail === 1, // the node itself is not entered
    kept: (first & 0x40) !== 0,
    node: 0,
    depth: 0,
    popped: null,
    pushed: [],
    written: [],
    evicted: null,
    hit: null,
    place: -1,
    shifts: 0,
    hidden: 0,
    read: -1,
    t_max: undefined,
  };
};

const kUnknown = { owner: 0, object: 0, gaussian: 0, t: NaN };
const visit_leaf = (event, k, from, values) => {
  const { outcome, popped } = event;
  if (outcome.name === 'miss') return;
  const owner = popped.instance !== 0 ? popped.instance : popped.node + 1;
  event.hit = { owner, object: popped.object, gaussian: gaussian_of(popped), t: from.time(values) };
  let out = null;
  if (outcome.replaces) {
    const place = from.number() - 2;
    if (place === -1) k.fill(kUnknown);
    if (place >= -1) [out] = k.splice(Math.max(0, place), 1);
  }
  if (outcome.enters) {
    event.place = from.number();
    event.hidden = page.bounded ? from.number() : 0;
    event.shifts = page.sorted ? k.length - event.place : from.number();
    k.splice(event.place, 0, event.hit);
    k.splice(k.length - event.hidden, event.hidden);
  }
  if (outcome.evicts) event.evicted = outcome.enters ? out : event.hit;
  if (event.kept) event.written.push({ ...popped, t: event.hit.t });
};
const visit_internal = (event, from, values) => {
  const { instance, object } = event.popped,
    below = nodes().first[event.node] - 1;
  const child = (slot) => ({ node: below + slot, instance, object, t: NaN, depth: event.depth + 1 });
  for (let left = from.u8(); left > 0; left -= 1) event.pushed.push(child(from.u8()));
  const mask = from.u8();
  for (let slot = 0; slot < 8; slot += 1) if (((mask >> slot) & 1) !== 0) event.written.push(child(slot));
  for (const entry of event.pushed) entry.t = from.time(values);
  for (const entry of event.written) entry.t = from.time(values);
};
const enter_instance = (event, from) => {
  const root = from.number(),
    { popped, node, depth } = event;
  const path = in_blas(root) ? { instance: node + 1, object: popped.object } : { instance: 0, object: node + 1 };
  event.pushed.push({ node: root, ...path, t: popped.t, depth: depth + 1 });
};
const read_source = (event, from, source) => {
  event.read = from.number();
  const entry = source[event.read];
  event.node = entry.node;
  if (event.kind === 'take') event.pushed.push({ ...entry, depth: 1 });
  else if (event.kept) event.written.push(entry);
};
// Takes the event's entry from the stack; returns the place where it was.
const pop = (event, from, stack) => {
  const place = stack.length - 1 - from.number();
  [event.popped] = stack.splice(place, 1);
  event.node = event.popped.node;
  event.depth = event.popped.depth;
  return place;
};

// The nodes that are under way from now on. pushed: entries that no earlier state holds.
export const start_nodes = (from, stack, pushed) => {
  for (let left = several ? from.number() : 0; left > 0; left -= 1) {
    const at = stack.length - 1 - from.number();
    if (pushed.includes(stack[at])) stack[at].under_way = true;
    else stack[at] = { ...stack[at], under_way: true };
  }
};

// Changes the lists {stack, k} of a state by the next event, and says what it did.
export const apply = ({ stack, k }, from, source, values) => {
  const first = from.u8();
  const event = begin_event(first);
  let place = stack.length;
  if (event.kind === 'take' || event.kind === 'forward') {
    read_source(event, from, source);
  } else if (event.transforms) {
    event.node = from.number();
    event.depth = 1;
  } else {
    place = pop(event, from, stack);
    if (event.kind === 'internal') visit_internal(event, from, values);
    else if (event.kind === 'instance') enter_instance(event, from);
    else if (event.kind === 'leaf') visit_leaf(event, k, from, values);
    else if (event.kept) event.written.push(event.popped);
  }
  stack.splice(place, 0, ...event.pushed.slice().reverse());
  if ((first & 0x80) !== 0) event.t_max = from.time(true);
  start_nodes(from, stack, event.pushed);
  return event;
};
