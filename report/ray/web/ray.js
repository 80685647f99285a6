// SPDX-License-Identifier: Apache-2.0
// Shows how rays were traced. A round's events lie packed in an element of their own (ray_replay.cpp says how) and are
// taken up when the round is looked at; of every list only the rows in sight are elements.
'use strict';

(() => {
  const page = JSON.parse(document.getElementById('page').textContent);
  const kRow = 22,
    kSnapshot = 256,
    kMostPixels = 8e6;
  const kKinds = ['internal', 'instance', 'leaf', 'cull', 'take', 'forward'];
  const kOutcomes = ['miss', 'behind', 'beyond', 'inserted', 'displaced', 'rejected', 'ignored', 'nearest'];
  const [INTERNAL, INSTANCE, LEAF, CULL, TAKE, FORWARD] = [0, 1, 2, 3, 4, 5];
  const NONE = 0xffffffff;
  const unsorted = page.tracing === 'single' || page.tracing === 'list'; // hits in order of arrival
  const several = page.ahead > 1; // nodes of a ray under way at once: events come in another order than depth first

  const bytes_of = (text) => {
    const raw = atob(text);
    const bytes = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i += 1) bytes[i] = raw.charCodeAt(i);
    return bytes;
  };
  const numbers = (Type, text) => new Type(bytes_of(text).buffer);
  const element = (tag, attributes = {}, ...children) => {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
      if (name in made && name !== 'list') made[name] = value;
      else made.setAttribute(name, value);
    }
    made.append(...children);
    return made;
  };
  const safe = (text) => String(text).replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`);
  const count = (n) => n.toLocaleString('en');
  const time = (t) => (t === undefined || Number.isNaN(t) ? '?' : t === Infinity ? '∞' : String(Number(t.toPrecision(5))));
  const hex = (n) => `0x${n.toString(16)}`;

  // Nodes.

  const warps = page.warps.map(({ nodes, timeline }) => ({
    timeline,
    address: numbers(Float64Array, nodes.address),
    kind: bytes_of(nodes.kind),
    parent: numbers(Uint32Array, nodes.parent),
    first: numbers(Uint32Array, nodes.first),
    gaussian: numbers(Uint32Array, nodes.gaussian),
    box: numbers(Float32Array, nodes.box),
  }));
  const gaussian_numbers = numbers(Uint32Array, page.gaussians.number);
  const gaussian_shapes = numbers(Float32Array, page.gaussians.shape);
  const gaussian_place = new Map(Array.from(gaussian_numbers, (number, i) => [number, i]));

  let ray = 0;
  const nodes = () => warps[page.rays[ray].warp];
  const in_blas = (node) => page.two_level && nodes().address[node] >= page.blas_base;
  // A leaf of 64 B in layout quantised: kinds 5 and 7.
  const is_wide = (node) => nodes().kind[node] > 4;
  const node_name = (node) => {
    const kind = nodes().kind[node];
    const what = kind === 0 ? 'node' : (is_wide(node) ? 'wide ' : '') + (kind === 1 || kind === 5 ? 'instance' : 'leaf');
    return `${in_blas(node) ? 'BLAS ' : ''}${what} ${hex(nodes().address[node])}`;
  };
  const gaussian_name = (hit) =>
    hit.gaussian !== 0
      ? `Gaussian ${hit.gaussian - 1}`
      : hit.owner !== 0
        ? `the Gaussian of ${node_name(hit.owner - 1)}`
        : 'a Gaussian that the trace does not name';
  // Of a Gaussian: centre, three half axes, colour, opacity, kernel radius in standard deviations.
  const shape = (gaussian) => {
    const at = gaussian_place.get(gaussian);
    return at === undefined ? null : gaussian_shapes.subarray(17 * at, 17 * at + 17);
  };
  // The Gaussian of an entry of the stack: numbers + 1, 0 when it is not known.
  const gaussian_of = (entry) => {
    const owner = entry.instance !== 0 ? entry.instance - 1 : entry.node;
    const local = nodes().gaussian[owner];
    if (local === NONE || nodes().address[owner] < page.objects_base) return 0;
    return (entry.object !== 0 && page.rays[ray].values ? nodes().gaussian[entry.object - 1] : 0) + local + 1;
  };

  // One event of a round, on a state {stack, k}. Returns what it did.

  class Bytes {
    constructor(bytes) {
      this.bytes = bytes;
      this.view = new DataView(bytes.buffer);
      this.at = 0;
    }
    u8() {
      return this.bytes[this.at++];
    }
    number() {
      let value = 0,
        factor = 1;
      for (;;) {
        const byte = this.bytes[this.at++];
        value += (byte & 127) * factor;
        if (byte < 128) return value;
        factor *= 128;
      }
    }
    time(there) {
      if (!there) return NaN;
      this.at += 4;
      return this.view.getFloat32(this.at - 4, true);
    }
  }

  const farthest = (k) => {
    if (!unsorted) return k.length - 1;
    let last = 0;
    for (let i = 1; i < k.length; i += 1) if (k[i].t > k[last].t || (k[i].t === k[last].t && k[i].gaussian > k[last].gaussian)) last = i;
    return last;
  };

  const new_event = (first, node) => {
    const nothing = { depth: 0, popped: null, pushed: [], written: [], evicted: null, hit: null, place: -1, read: -1, t_max: undefined };
    return { kind: first & 7, detail: (first >> 3) & 7, kept: (first & 0x40) !== 0, node, ...nothing };
  };
  const visit_leaf = (event, k, from, values) => {
    const outcome = event.detail;
    const shifts = outcome === 3 || outcome === 4 ? from.number() : 0;
    if (outcome !== 0) {
      const owner = event.popped.instance !== 0 ? event.popped.instance : event.popped.node + 1;
      event.hit = { owner, object: event.popped.object, gaussian: gaussian_of(event.popped), t: from.time(values) };
    }
    if (outcome === 4) {
      const at = farthest(k);
      if (unsorted && !values) for (let i = 0; i < k.length; i += 1) k[i] = { owner: 0, object: 0, gaussian: 0, t: NaN };
      event.evicted = k[at];
      k.splice(at, 1);
    } else if (outcome === 5) {
      event.evicted = event.hit;
    } else if (outcome === 7) {
      k.length = 0;
    }
    if (outcome === 3 || outcome === 4 || outcome === 7) {
      event.place = k.length - (unsorted ? 0 : shifts);
      event.shifts = shifts;
      k.splice(event.place, 0, event.hit);
    }
    if (outcome === 2 && event.kept) event.written.push({ ...event.popped, t: event.hit.t });
  };
  const apply = (state, from, source, values) => {
    const first = from.u8();
    const event = new_event(first, from.number());
    const { stack, k } = state;
    let place = stack.length;
    if (event.kind !== TAKE && event.kind !== FORWARD && !(event.kind === INSTANCE && event.detail === 1)) {
      place -= 1;
      while (several && stack[place].node !== event.node) place -= 1; // a node under way keeps its place
      [event.popped] = stack.splice(place, 1);
      event.depth = event.popped.depth;
    }
    const popped = event.popped;
    if (event.kind === INTERNAL) {
      const below = nodes().first[event.node] - 1;
      const child = (slot) => ({ node: below + slot, instance: popped.instance, object: popped.object, t: NaN, depth: popped.depth + 1 });
      const pushes = from.u8();
      for (let i = 0; i < pushes; i += 1) event.pushed.push(child(from.u8()));
      const mask = from.u8();
      for (let slot = 0; slot < 8; slot += 1) if (((mask >> slot) & 1) !== 0) event.written.push(child(slot));
      for (const entry of event.pushed) entry.t = from.time(values);
      for (const entry of event.written) entry.t = from.time(values);
      stack.splice(place, 0, ...event.pushed.slice().reverse());
    } else if (event.kind === INSTANCE) {
      if (event.detail === 1) {
        event.depth = 1;
      } else {
        const root = from.number();
        const blas = in_blas(root);
        event.pushed.push({
          node: root,
          instance: blas ? event.node + 1 : 0,
          object: blas ? popped.object : event.node + 1,
          t: popped.t,
          depth: popped.depth + 1,
        });
        stack.push(event.pushed[0]);
      }
    } else if (event.kind === LEAF) {
      visit_leaf(event, k, from, values);
    } else if (event.kind === CULL) {
      if (event.kept) event.written.push(popped);
    } else {
      event.read = from.number();
      const entry = source[event.read];
      if (event.kind === TAKE) {
        event.pushed.push({ ...entry, depth: 1 });
        stack.push(event.pushed[0]);
      } else if (event.kept) {
        event.written.push(entry);
      }
    }
    if ((first & 0x80) !== 0) event.t_max = from.time(true);
    return event;
  };

  // A round, taken up as a whole: what lies where, and the lists, which only grow, with the event that wrote each entry.

  const rounds = new Map();
  // Takes up the events of a round one after the other, from the state at its beginning.
  const play_through = (made, state, replay) => {
    const { from, events } = made;
    if (!replay && events > 0) {
      state.stack.push({ node: 0, instance: 0, object: 0, t: made.values ? 0 : NaN, depth: 0 });
    }
    let now = made.first_t_max;
    for (let i = 0; i < events; i += 1) {
      if (i % kSnapshot === 0) made.snapshots.push({ at: from.at, k: state.k.slice(), stack: state.stack.slice() });
      made.at[i] = from.at;
      const event = apply(state, from, made.source, made.values);
      if (event.t_max !== undefined) now = event.t_max;
      made.t_max[i] = now;
      made.node[i] = event.node;
      made.look[i] = event.kind === LEAF ? 8 + event.detail : event.kind;
      made.depth[i] = event.depth;
      if (event.hit !== null) {
        made.gaussian[i] = event.hit.gaussian;
        made.time[i] = event.hit.t;
      } else if (event.kind === INSTANCE) {
        made.gaussian[i] = gaussian_of({
          node: event.node,
          instance: event.node + 1,
          object: (event.popped || state.stack[state.stack.length - 1]).object,
        });
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
      const hit = event.kind === LEAF && event.detail >= 3 && event.detail !== 6;
      made.noted[i] = hit ? 2 : event.written.length > 0 && event.kind !== FORWARD ? 1 : 0;
    }
  };
  const find_subtrees = (made) => {
    const { events } = made;
    // Where the part of the tree below each event ends, and the most that is noted in it. With several nodes under way
    // what comes next need not be below: each event stands alone.
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
  const round_of = (of_ray, number) => {
    const id = `r${of_ray}_${number}`;
    if (rounds.has(id)) return rounds.get(id);
    const values = page.rays[of_ray].values;
    const from = new Bytes(bytes_of(document.getElementById(id).textContent));
    const hits = () =>
      Array.from({ length: from.number() }, () => ({
        owner: from.number(),
        object: from.number(),
        gaussian: from.number(),
        t: from.time(values),
      }));
    const k = hits(),
      evictions = hits();
    const source = Array.from({ length: from.number() }, () => ({
      node: from.number(),
      instance: from.number(),
      object: from.number(),
      t: from.time(values),
      depth: 0,
    }));
    const t_max = from.time(values);
    const events = page.rays[of_ray].rounds[number].events;
    const made = {
      values,
      from,
      events,
      source,
      first_t_max: t_max,
      first_evictions: evictions.length,
      read_at: new Int32Array(source.length).fill(events),
      at: new Uint32Array(events),
      node: new Uint32Array(events),
      look: new Uint8Array(events),
      depth: new Uint16Array(events),
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
      open: new Set(),
      rows: null,
    };
    play_through(made, { k, stack: [] }, page.rays[of_ray].rounds[number].replay);
    find_subtrees(made);
    rounds.set(id, made);
    return made;
  };

  // The state after event i of a round; -1: as the round begins. `event` is what event i did.
  const state_at = (round, i) => {
    const place = Math.floor(Math.max(i, 0) / kSnapshot);
    const state =
      round.snapshots.length > 0
        ? { k: round.snapshots[place].k.slice(), stack: round.snapshots[place].stack.slice() }
        : { k: [], stack: [] };
    if (round.snapshots.length === 0) {
      // a round without an event
      const from = new Bytes(round.from.bytes);
      state.k = Array.from({ length: from.number() }, () => ({
        owner: from.number(),
        object: from.number(),
        gaussian: from.number(),
        t: from.time(round.values),
      }));
    }
    let event = null;
    if (i >= 0) {
      round.from.at = round.snapshots[place].at;
      for (let e = place * kSnapshot; e <= i; e += 1) event = apply(state, round.from, round.source, round.values);
    }
    return { ...state, event };
  };
  // The entries of the stack that are under way after event i: those of the next events that read a node.
  const under_way = (round, i, stack) => {
    const waiting = new Map(stack.map((entry) => [entry.node, entry])),
      found = new Set();
    for (let e = i + 1; several && e < round.events && found.size < Math.min(page.ahead, waiting.size); e += 1) {
      const entry = waiting.get(round.node[e]);
      if (entry !== undefined && round.look[e] !== CULL) found.add(entry);
      else if (entry !== undefined) waiting.delete(round.node[e]);
    }
    return found;
  };
  const until = (stamps, i) => {
    // how many of the ascending stamps are at most i
    let low = 0,
      high = stamps.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (stamps[middle] <= i) low = middle + 1;
      else high = middle;
    }
    return low;
  };

  // A list of which only the rows in sight are elements.

  class List {
    constructor(box, write) {
      this.box = box;
      this.write = write;
      this.inside = element('div');
      box.append(this.inside);
      box.addEventListener('scroll', () => this.draw());
      this.rows = 0;
    }
    show(rows) {
      this.rows = rows;
      this.full = rows * kRow;
      this.height = Math.min(this.full, kMostPixels);
      this.inside.style.height = `${this.height}px`;
      this.draw();
    }
    // Pixels of all rows above the first in sight; a very long list is scrolled in proportion.
    top() {
      const sight = this.box.clientHeight;
      return this.full <= kMostPixels ? this.box.scrollTop : (this.box.scrollTop / Math.max(1, this.height - sight)) * (this.full - sight);
    }
    reveal(row) {
      const sight = this.box.clientHeight,
        top = this.top();
      if (row * kRow >= top && (row + 1) * kRow <= top + sight) return;
      const wanted = Math.max(0, Math.min(this.full - sight, row * kRow - sight / 2));
      this.box.scrollTop = this.full <= kMostPixels ? wanted : (wanted / Math.max(1, this.full - sight)) * (this.height - sight);
    }
    draw() {
      const top = this.top(),
        first = Math.max(0, Math.floor(top / kRow) - 4);
      const last = Math.min(this.rows, Math.ceil((top + this.box.clientHeight) / kRow) + 4);
      let html = '';
      for (let row = first; row < last; row += 1) html += this.write(row, `top:${Math.round(this.box.scrollTop + row * kRow - top)}px`);
      this.inside.innerHTML = html;
    }
  }

  // What the page consists of.

  const player = document.getElementById('player');
  const button = (text, title, action) =>
    element('button', { type: 'button', textContent: text, title, 'aria-label': title, onclick: action });
  const ray_choice = element(
    'select',
    { 'aria-label': 'Ray' },
    ...page.rays.map((r, i) => element('option', { value: i, textContent: r.name })),
  );
  const speed = element(
    'select',
    { 'aria-label': 'Events a second' },
    ...[1, 4, 16, 64, 256].map((n) => element('option', { value: n, textContent: `${n}/s`, selected: n === 4 })),
  );
  const fold = element(
    'select',
    { 'aria-label': 'What is folded' },
    element('option', { value: 2, textContent: 'no hit' }),
    element('option', { value: 1, textContent: 'no hit, no checkpoint' }),
    element('option', { value: 0, textContent: 'nothing' }),
  );
  const slider = element('input', { type: 'range', min: 0, step: 1, 'aria-label': 'Event' });
  const search = element('input', {
    type: 'search',
    placeholder: '0x address or Gaussian',
    'aria-label': 'Find a node by its address or a Gaussian by its number',
  });
  const where = element('span', { className: 'where', role: 'status' });
  const play_button = button('play', 'Play (space)', () => toggle_play());
  const tools = element(
    'div',
    { className: 'bar-of-tools', role: 'group', 'aria-label': 'Player' },
    ...(page.rays.length > 1 ? [ray_choice] : []),
    button('|◀', 'First event (Home)', () => go_to(0)),
    button('‹', 'One event back (left arrow)', () => go_to(position - 1)),
    play_button,
    button('›', 'One event on (right arrow)', () => go_to(position + 1)),
    button('▶|', 'Last event (End)', () => go_to(total() - 1)),
    button('‹ hit', 'Last event that called the any-hit shader (p)', () => next_noted(-1)),
    button('hit ›', 'Next event that called the any-hit shader (n)', () => next_noted(1)),
    speed,
    element('label', {}, 'fold', fold),
    search,
    where,
    slider,
  );
  const keys = element('details', { className: 'keys' });
  keys.innerHTML =
    '<summary>Keys, colours</summary><p><kbd>←</kbd> <kbd>→</kbd> an event · <kbd>n</kbd> <kbd>p</kbd> next, last hit · ' +
    '<kbd>[</kbd> <kbd>]</kbd> a round · <kbd>Home</kbd> <kbd>End</kbd> · <kbd>space</kbd> play · <kbd>/</kbd> find, ' +
    '<kbd>Enter</kbd> the next one · in a list <kbd>↑</kbd> <kbd>↓</kbd> a row, <kbd>Enter</kbd> fold. ' +
    'In the view: arrows turn, <kbd>+</kbd> <kbd>-</kbd> zoom.</p>' +
    `<p>${[
      ['internal', 'node'],
      ['instance', 'instance leaf'],
      ['miss', 'leaf missed'],
      ['behind', 'hit, seen before'],
      ['inserted', 'hit, into the k-buffer'],
      ['displaced', 'hit, another fell out'],
      ['rejected', 'hit, rejected'],
      ['beyond', 'beyond t_max'],
      ['take', 'checkpoint taken'],
    ]
      .map(([k, text]) => `<span class="row k-${k}" style="position:static;display:inline-block"><span class="dot"></span>${text}</span>`)
      .join('')}</p>`;
  const axis = element('section', { className: 'axis', hidden: true, 'aria-label': 'Time axis' }),
    axis_canvas = element('canvas', { role: 'img' }),
    axis_text = element('p');
  axis.append(axis_canvas, axis_text);
  const strip = element('div', { className: 'strip', tabIndex: -1 }),
    strip_inside = element('div');
  strip.append(strip_inside);
  const panel = (title, tall = false) => {
    const made = {
      note: element('span'),
      list: element('div', { className: tall ? 'list tall' : 'list', tabIndex: 0, role: 'list', 'aria-label': title }),
    };
    made.section = element('section', {}, element('h2', {}, title, made.note), made.list);
    return made;
  };
  const event_box = element('section', { className: 'event', 'aria-live': 'polite', 'aria-label': 'Event' });
  const k_panel = panel('k-buffer', true),
    eviction_panel = panel('Eviction list'),
    stack_panel = panel('Stack');
  const source_panel = panel('Source list'),
    destination_panel = panel('Destination list');
  k_panel.section.id = 'k_buffer';
  eviction_panel.section.id = 'evictions';
  source_panel.section.id = 'source';
  destination_panel.section.id = 'destination';
  stack_panel.section.id = 'stack';
  event_box.id = 'event';
  const state_box = element(
    'div',
    { className: 'state' },
    event_box,
    k_panel.section,
    element('div', { className: 'pair-of-lists' }, eviction_panel.section, stack_panel.section),
    element('div', { className: 'pair-of-lists' }, source_panel.section, destination_panel.section),
  );
  for (const { section } of [eviction_panel, source_panel, destination_panel]) section.hidden = !page.checkpoint;
  const view_box = element('section', { className: 'view3d', hidden: true, 'aria-label': 'Boxes and Gaussians' });
  const story = element('p', { className: 'story' });
  const pixel_box = element('figure', { className: 'pixel' }),
    hits_box = element('section', { className: 'hits', 'aria-label': 'Hits by distance' });
  const hits_canvas = element('canvas', { role: 'img', tabIndex: 0 }),
    hits_text = element('p', { className: 'note', role: 'status' });
  hits_box.append(element('h2', { textContent: 'Its hits along the ray' }), hits_canvas, hits_text);
  player.append(
    element('div', { className: 'first-look' }, pixel_box, element('div', {}, story, hits_box)),
    tools,
    keys,
    axis,
    element('div', { className: 'stage' }, strip, state_box),
    view_box,
  );

  // Positions: round after round, each from -1 (it begins) to its last event.

  let position = 0,
    offsets = [],
    playing = null;
  const summary = (r) => page.rays[ray].rounds[r];
  const total = () => offsets[offsets.length - 1];
  const place_of = (at) => {
    let r = until(offsets, at) - 1;
    r = Math.min(r, page.rays[ray].rounds.length - 1);
    return { r, i: at - offsets[r] - 1 };
  };

  // Rounds side by side.

  const columns = new Map();
  const fold_level = () => Number(fold.value);
  const rows_of = (round) => {
    if (round.rows !== null) return round.rows;
    const level = fold_level(),
      rows = [];
    for (let i = 0; i < round.events;) {
      let end = i;
      while (end < round.events && round.in_subtree[end] < level) end = round.end[end];
      if (end - i > 2 && !round.open.has(i)) {
        rows.push(i, end);
        i = end;
      } else if (end > i) {
        for (; i < end; i += 1) rows.push(i, i + 1);
      } else {
        rows.push(i, i + 1);
        i += 1;
      }
    }
    round.rows = Uint32Array.from(rows);
    return round.rows;
  };
  const row_of = (round, i) => {
    const rows = rows_of(round);
    let low = 0,
      high = rows.length / 2 - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (rows[2 * middle] <= i) low = middle;
      else high = middle - 1;
    }
    return low;
  };
  // Whole, where a row has no room.
  const row_title = (round, i) => {
    const known = round.gaussian[i] !== 0 ? `, Gaussian ${round.gaussian[i] - 1}` : '';
    return `${node_name(round.node[i])}${known}, ${class_of(round.look[i])}`;
  };
  const folded_text = (round, begin, end) => {
    let read = 0,
      kept = 0;
    for (let i = begin; i < end; i += 1) {
      const look = round.look[i];
      read += look < 3 || look >= 8 ? 1 : 0;
      kept += round.noted[i] === 1 ? 1 : 0;
    }
    const parts = read > 0 ? [`${count(read)} node${read === 1 ? '' : 's'} without a hit`] : [];
    if (read < end - begin) parts.push(`${count(end - begin - read)} not read`);
    if (kept > 0) parts.push(`${count(kept)} checkpointed`);
    return parts.join(', ');
  };
  const class_of = (look) => (look >= 8 ? kOutcomes[look - 8] : kKinds[look]);
  const write_row = (round, r, now) => (row, style) => {
    const rows = rows_of(round),
      i = rows[2 * row],
      end = rows[2 * row + 1];
    const chosen = now.r === r && now.i >= i && now.i < end;
    const indent = '<span class="i"></span>'.repeat(Math.min(round.depth[i], 16));
    const mark = chosen ? ' now' : '';
    const title = end - i > 1 ? '' : safe(row_title(round, i));
    const open = `style="${style}" title="${title}" role="option" id="e${r}_${i}" data-event="${i}" aria-selected="${chosen}"`;
    if (end - i > 1) return `<div class="row fold${mark}" ${open} data-fold="1">${indent}▸ ${folded_text(round, i, end)}</div>`;
    const look = round.look[i],
      node = round.node[i];
    const known = round.gaussian[i] !== 0 ? `G ${round.gaussian[i] - 1}` : '';
    const at = look > 8 && round.values && !Number.isNaN(round.time[i]) ? ` at ${time(round.time[i])}` : '';
    const text =
      look > 8
        ? `${kOutcomes[look - 8]} ${known}${at} <span class="m">${node_name(node)}</span>`
        : look === 8
          ? `${node_name(node)} <span class="m">miss</span>`
          : look === CULL
            ? `${node_name(node)} <span class="m">not read: beyond t_max</span>`
            : look === TAKE
              ? `take ${node_name(node)}`
              : look === FORWARD
                ? `forward ${node_name(node)}`
                : look === INSTANCE && transforms(round, i)
                  ? `${node_name(node)} <span class="m">transform ${known}</span>`
                  : `${node_name(node)} <span class="m">${known}</span>`;
    return `<div class="row k-${class_of(look)}${mark}" ${open}>${indent}<span class="dot"></span>${text}</div>`;
  };
  // Whether an instance leaf is not entered, only used to transform the ray again.
  const transforms = (round, i) => ((round.from.bytes[round.at[i]] >> 3) & 7) === 1;

  const column_width = () =>
    strip.clientWidth < 520 ? strip.clientWidth : Math.floor(strip.clientWidth / Math.max(2, Math.floor(strip.clientWidth / 330)));
  const head_text = (r) => {
    const s = summary(r);
    const visits = s.visits[0] + s.visits[1] + s.visits[2];
    const parts = [
      `${count(s.events)} events, ${count(visits)} nodes read`,
      `k-buffer ${s.preloaded > 0 ? `${s.preloaded} preloaded, ` : ''}${s.hits} hits, ${s.blended} blended`,
    ];
    if (page.checkpoint)
      parts.push(`checkpoints ${s.taken} taken, ${s.forwarded} forwarded, ${s.written} written; ${s.outcomes[4] + s.outcomes[5]} evicted`);
    if (s.transmittance !== undefined) parts.push(`light let through ${time(s.transmittance)}`);
    const span = nodes().timeline.find(([name, round]) => name === '' && round === r);
    if (span) parts.push(`cycles ${count(span[2])} to ${count(span[3])}`);
    const end = s.terminated ? ', ends the ray' : s.overflow ? ', list ran full' : '';
    return `<b>Round ${r}</b> from ${s.replay ? 'its checkpoints' : 'the root'}${end}<br>${parts.map(safe).join('<br>')}`;
  };
  const draw_strip = () => {
    const width = column_width(),
      all = page.rays[ray].rounds.length;
    strip_inside.style.width = `${width * all}px`;
    strip_inside.style.height = `${Math.max(420, Math.min(760, innerHeight - 140))}px`;
    const first = Math.max(0, Math.floor(strip.scrollLeft / width)),
      last = Math.min(all - 1, Math.floor((strip.scrollLeft + strip.clientWidth - 1) / width));
    for (const [r, column] of columns) {
      if (r >= first && r <= last) continue;
      column.box.remove();
      columns.delete(r);
    }
    const now = place_of(position);
    for (let r = first; r <= last; r += 1) {
      let column = columns.get(r);
      if (!column) {
        const round = round_of(ray, r);
        const head = element('header');
        head.innerHTML = head_text(r);
        const list = element('div', { className: 'list', tabIndex: 0, role: 'listbox', 'aria-label': `Events of round ${r}` });
        column = { round, box: element('div', { className: 'round' }, head, list) };
        strip_inside.append(column.box);
        column.list = new List(list, (row, style) => write_row(round, r, place_of(position))(row, style));
        list.addEventListener('click', (event) => {
          const row = event.target.closest('.row');
          if (row) choose_row(r, Number(row.dataset.event), row.dataset.fold === '1');
        });
        list.addEventListener('keydown', (event) => list_key(event, r));
        columns.set(r, column);
        column.box.style.left = `${r * width}px`;
        column.box.style.width = `${width}px`;
        column.list.show(rows_of(round).length / 2);
      }
      column.box.style.left = `${r * width}px`;
      column.box.style.width = `${width}px`;
      column.box.classList.toggle('now', r === now.r);
      column.list.show(rows_of(column.round).length / 2);
    }
  };
  const choose_row = (r, i, folded) => {
    if (folded) {
      const round = round_of(ray, r);
      round.open.add(i);
      round.rows = null;
    }
    go_to(offsets[r] + 1 + i);
  };
  const list_key = (event, r) => {
    const round = round_of(ray, r),
      now = place_of(position);
    const row = now.r === r && now.i >= 0 ? row_of(round, now.i) : -1;
    const rows = rows_of(round);
    if (event.key === 'ArrowDown' || event.key === 'ArrowUp') {
      const next = Math.max(0, Math.min(rows.length / 2 - 1, row + (event.key === 'ArrowDown' ? 1 : -1)));
      if (rows.length > 0) go_to(offsets[r] + 1 + rows[2 * next]);
    } else if (event.key === 'Enter' && row >= 0) {
      const begin = rows[2 * row];
      if (rows[2 * row + 1] - begin > 1) {
        round.open.add(begin);
      } else {
        // the opened run that this event is in
        let run = -1;
        for (const opened of round.open) if (opened <= begin && opened > run) run = opened;
        round.open.delete(run);
      }
      round.rows = null;
      draw_strip();
      columns.get(r).list.reveal(row_of(round, now.i));
    } else {
      return;
    }
    event.preventDefault();
    event.stopPropagation();
  };

  // What an event did, in words.

  const nodes_text = (list) => `${list.length} ${list.length === 1 ? 'entry' : 'entries'}`;
  const read_text = (event) => {
    const at = nodes().address[event.node];
    const sectors = (bytes) => Math.floor((at + bytes - 1) / 32) - Math.floor(at / 32) + 1;
    if (event.kind === CULL || event.kind === FORWARD) return 'no node';
    if (event.kind === TAKE) return `a checkpoint entry, ${page.entry_bytes.checkpoint} B`;
    const leaf = event.kind === INSTANCE ? page.reads.instance : page.reads.leaf;
    const bytes = event.kind === INTERNAL ? page.reads.internal : is_wide(event.node) ? page.reads.wide : leaf;
    const header =
      event.kind === INSTANCE && event.detail === 0 && page.reads.header > 0 ? `, and the header below it, ${page.reads.header} B` : '';
    return `${bytes} B at ${hex(at)} (${sectors(bytes)} sectors)${header}`;
  };
  const headline = (event) => {
    const name = node_name(event.node),
      kept = event.written.length > 0 ? `, ${event.written.length} checkpointed` : '';
    switch (event.kind) {
      case INTERNAL:
        return `${name}: ${event.pushed.length} of its children pushed${kept}`;
      case INSTANCE:
        return event.detail === 1
          ? `${name}: the ray is transformed again`
          : `${name}: the ray is transformed, ${node_name(event.pushed[0].node)} pushed`;
      case CULL:
        return `${name} lies beyond t_max: popped, not read`;
      case TAKE:
        return `Entry ${event.read} taken: ${name}`;
      case FORWARD:
        return `Entry ${event.read} lies beyond t_max: ${name} not read`;
      default:
        break;
    }
    if (event.detail === 0) return `${name} missed`;
    const hit = `${name} hit: ${gaussian_name(event.hit)}${Number.isNaN(event.hit.t) ? '' : ` at t = ${time(event.hit.t)}`}`;
    return (
      hit +
      [
        null,
        ', before t_min: blended already',
        ', beyond t_max',
        ', inserted',
        ', inserted, the last one falls out',
        ', rejected',
        ', ignored',
        ', nearest so far',
      ][event.detail]
    );
  };
  const copied = (event) => {
    const texts = [];
    if (event.place >= 0) {
      const moved =
        event.shifts > 0 && page.tracing !== 'closest'
          ? `; ${event.shifts} ${event.shifts === 1 ? 'entry moves' : 'entries move'} ${unsorted ? 'in the heap' : 'one place back'}`
          : '';
      texts.push(`${gaussian_name(event.hit)} to place ${event.place} of the k-buffer${moved}`);
    }
    if (event.evicted !== null)
      texts.push(
        page.checkpoint
          ? `${gaussian_name(event.evicted)} to the eviction list, ${page.entry_bytes.eviction} B`
          : `${gaussian_name(event.evicted)} is dropped: the next round meets it again`,
      );
    if (event.kind === TAKE) texts.push('the entry to the stack');
    if (event.written.length > 0)
      texts.push(
        `${nodes_text(event.written)} to the list that the next round reads, ${event.written.length * page.entry_bytes.checkpoint} B`,
      );
    else if (event.kind === CULL || event.kind === FORWARD || (event.kind === LEAF && event.detail === 2))
      texts.push(page.checkpoint ? 'nothing: dropped' : 'nothing: the next round starts at the root');
    return texts;
  };
  const begin_text = (r) => {
    const s = summary(r);
    const texts = [
      s.replay
        ? 'The round goes on from the checkpoints of the one before. Its stack is empty.'
        : r === 0
          ? 'The ray begins at the root.'
          : 'The round starts at the root again.',
    ];
    if (s.preloaded > 0)
      texts.push(
        s.preloaded === 1 ? 'One hit comes from the eviction list.' : `${s.preloaded} hits come from the eviction list, the nearest first.`,
      );
    return texts;
  };
  const end_text = (r) => {
    const s = summary(r);
    const light = s.transmittance === undefined ? '' : `; light let through ${time(s.transmittance)}`;
    const end = s.terminated ? '. The ray is opaque and ends' : s.overflow ? '. The checkpoint list ran full: it is dropped' : '';
    return `The round is over: ${s.hits} hits in the k-buffer, ${s.processed} looked at, ${s.blended} blended${light}${end}.`;
  };

  // Lists of the state. Evictions and checkpoints are shown by their t, with their place in the list before it.

  const kMostSorted = 4096;
  const by_time = (list, length) => {
    const order = Array.from({ length }, (unused, i) => i);
    return shown.round.values && length <= kMostSorted ? order.sort((a, b) => list[a].t - list[b].t || a - b) : order;
  };
  const orders = { evictions: [], source: [], destination: [] };

  let shown = null;
  const list_row = (number, style, look, data, title, text, at) =>
    `<div class="row${look}" role="listitem" style="${style}" ${data}><span>${number}</span>` +
    `<span title="${safe(title)}">${text}</span><span>${shown.round.values ? time(at) : ''}</span></div>`;
  const hit_row = (number, hit, style, look) => {
    if (hit === undefined) {
      return `<div class="row" role="listitem" style="${style}"><span>${number}</span><span class="m">empty</span><span></span></div>`;
    }
    const owner = hit.owner !== 0 ? hit.owner - 1 : -1,
      gaussian = hit.gaussian - 1;
    const text = gaussian >= 0 ? `G ${gaussian}` : owner >= 0 ? hex(nodes().address[owner]) : '?';
    const title = gaussian_name(hit) + (owner >= 0 ? `, ${node_name(owner)}` : '');
    return list_row(number, style, look, `data-gaussian="${gaussian}" data-t="${hit.t}"`, title, text, hit.t);
  };
  const node_row = (number, entry, style, look) => {
    const address = hex(nodes().address[entry.node]),
      gaussian = gaussian_of(entry);
    const title = node_name(entry.node) + (entry.instance !== 0 ? ` in ${node_name(entry.instance - 1)}` : '');
    const text =
      address +
      (gaussian !== 0 ? ` <span class="m">G ${gaussian - 1}</span>` : '') +
      (shown.under_way.has(entry) ? ' <span class="m">under way</span>' : '');
    return list_row(number, style, look, `data-node="${address}"`, title, text, entry.t);
  };
  const k_list = new List(k_panel.list, (row, style) =>
    hit_row(row, shown.k[row], style, shown.event !== null && shown.event.place === row ? ' new' : ''),
  );
  const eviction_list = new List(eviction_panel.list, (row, style) => {
    const at = orders.evictions[row];
    return hit_row(at, shown.round.evictions[at], style, shown.round.evicted_at[at] === shown.i && shown.i >= 0 ? ' new' : '');
  });
  const stack_list = new List(stack_panel.list, (row, style) =>
    node_row(
      row,
      shown.stack[shown.stack.length - 1 - row],
      style,
      shown.event !== null && shown.event.pushed.includes(shown.stack[shown.stack.length - 1 - row]) ? ' new' : '',
    ),
  );
  const source_list = new List(source_panel.list, (row, style) => {
    const at = orders.source[row],
      read = shown.round.read_at[at];
    return node_row(at, shown.round.source[at], style, read === shown.i ? ' new' : read < shown.i ? ' gone' : '');
  });
  const destination_list = new List(destination_panel.list, (row, style) => {
    const at = orders.destination[row];
    return node_row(at, shown.round.destination[at], style, shown.round.destination_at[at] === shown.i ? ' new' : '');
  });

  const show = () => {
    const { r, i } = place_of(position);
    const round = round_of(ray, r);
    shown = { ...state_at(round, i), round, r, i };
    shown.under_way = under_way(round, i, shown.stack);
    const t_max = i < 0 ? round.first_t_max : round.t_max[i];
    const before = i < 1 ? round.first_t_max : round.t_max[i - 1];
    const lines = [];
    if (i < 0) {
      lines.push(`<p class="what">Round ${r} begins</p>`, ...begin_text(r).map((text) => `<p>${safe(text)}</p>`));
    } else {
      lines.push(`<p class="what">${safe(headline(shown.event))}</p>`, `<p><b>Read:</b> ${safe(read_text(shown.event))}</p>`);
      const texts = copied(shown.event);
      if (texts.length > 0) lines.push(`<p><b>Copied:</b> ${safe(texts.join('; '))}</p>`);
    }
    if (round.values)
      lines.push(
        `<p id="t_max" data-t="${t_max}"><b>t_max:</b> ${before !== t_max && i >= 0 ? `${time(before)} → ` : ''}${time(t_max)}</p>`,
      );
    else lines.push('<p id="t_max"><b>t_max:</b> not in the trace</p>');
    if (i === round.events - 1) lines.push(`<p>${safe(end_text(r))}</p>`);
    event_box.innerHTML = `<h2>Round ${r}, ${i < 0 ? 'its beginning' : `event ${count(i)}`}<span></span></h2>${lines.join('')}`;
    const last = unsorted && i === round.events - 1 ? ', sorted when the round ends' : unsorted ? ', a heap: in order of arrival' : '';
    k_panel.note.textContent = `${shown.k.length} of ${page.k}${last}`;
    k_list.show(page.k <= 64 ? page.k : shown.k.length);
    const evicted = until(round.evicted_at, i),
      written = until(round.destination_at, i);
    orders.evictions = by_time(round.evictions, evicted);
    orders.source = by_time(round.source, round.source.length);
    orders.destination = by_time(round.destination, written);
    eviction_panel.note.textContent = count(evicted);
    eviction_list.show(evicted);
    stack_panel.note.textContent = count(shown.stack.length) + (several ? `, ${shown.under_way.size} under way` : '');
    stack_list.show(shown.stack.length);
    let left = 0;
    for (const at of round.read_at) left += at > i ? 1 : 0;
    source_panel.note.textContent = `${count(left)} of ${count(round.source.length)}`;
    source_list.show(round.source.length);
    destination_panel.note.textContent = count(written);
    destination_list.show(written);
    if (shown.event !== null && shown.event.place >= 0) k_list.reveal(shown.event.place);
    if (evicted > 0) eviction_list.reveal(orders.evictions.indexOf(evicted - 1));
    if (written > 0) destination_list.reveal(orders.destination.indexOf(written - 1));
    if (shown.event !== null && shown.event.read >= 0) source_list.reveal(orders.source.indexOf(shown.event.read));
    const last_event = count(Math.max(0, round.events - 1));
    where.textContent = `round ${r} of 0–${page.rays[ray].rounds.length - 1}, event ${i < 0 ? '–' : count(i)} of 0–${last_event}`;
    slider.value = position;
    slider.setAttribute('aria-valuetext', where.textContent);
    draw_axis();
    draw_hits();
    draw_view();
  };

  const go_to = (at) => {
    position = Math.max(0, Math.min(total() - 1, at));
    const { r, i } = place_of(position);
    const width = column_width();
    if (r * width < strip.scrollLeft || (r + 1) * width > strip.scrollLeft + strip.clientWidth + 1) {
      strip.scrollLeft = Math.max(0, r * width - (strip.clientWidth > 2 * width - 2 ? width / 4 : 0));
    }
    draw_strip();
    const column = columns.get(r);
    if (column) {
      if (i >= 0) column.list.reveal(row_of(column.round, i));
      const list = column.box.querySelector('.list');
      if (i >= 0) list.setAttribute('aria-activedescendant', `e${r}_${rows_of(column.round)[2 * row_of(column.round, i)]}`);
    }
    show();
  };
  const next_noted = (step) => {
    let { r, i } = place_of(position);
    for (; r >= 0 && r < page.rays[ray].rounds.length; r += step) {
      const round = round_of(ray, r);
      for (i += step; i >= 0 && i < round.events; i += step) if (round.noted[i] === 2) return go_to(offsets[r] + 1 + i);
      i = step > 0 ? -1 : r > 0 ? summary(r - 1).events : 0;
    }
    where.textContent = step > 0 ? 'no hit behind this event' : 'no hit before this event';
    return undefined;
  };
  const next_round = (step) => {
    const { r, i } = place_of(position);
    const next = step < 0 && i >= 0 ? r : r + step;
    go_to(offsets[Math.max(0, Math.min(page.rays[ray].rounds.length - 1, next))]);
  };
  const toggle_play = () => {
    if (playing !== null) {
      clearInterval(playing);
      playing = null;
    } else {
      if (position >= total() - 1) position = 0;
      const rate = Number(speed.value),
        frames = Math.min(rate, 32);
      playing = setInterval(() => {
        go_to(position + rate / frames);
        if (position >= total() - 1) toggle_play();
      }, 1000 / frames);
    }
    event_box.setAttribute('aria-live', playing === null ? 'polite' : 'off');
    play_button.textContent = playing === null ? 'play' : 'pause';
    play_button.title = playing === null ? 'Play (space)' : 'Pause (space)';
    play_button.setAttribute('aria-label', play_button.title);
  };

  // Finding a node or a Gaussian: the events that are about it, one after the other.

  let search_run = 0;
  const find = async () => {
    const text = search.value.trim().replace(/^#/, '');
    const run = ++search_run;
    if (text === '') return;
    const wanted = Number(text),
      address = /^0x/i.test(text);
    const node = address ? nodes().address.indexOf(wanted) : -1;
    let found = 0,
      first = -1,
      next = -1,
      began = performance.now();
    for (let r = 0; r < page.rays[ray].rounds.length && (!address || node >= 0); r += 1) {
      const round = round_of(ray, r);
      for (let i = 0; i < round.events; i += 1) {
        if (address ? round.node[i] !== node : round.gaussian[i] !== wanted + 1) continue;
        found += 1;
        const at = offsets[r] + 1 + i;
        if (first < 0) first = at;
        if (next < 0 && at > position) next = at;
      }
      if (performance.now() - began > 30) {
        // the page stays alive while it looks
        await new Promise((resolve) => {
          setTimeout(resolve);
        });
        if (run !== search_run) return;
        began = performance.now();
      }
    }
    if (found > 0) go_to(next >= 0 ? next : first);
    where.textContent =
      found === 0
        ? `${text}: this ray has no event about it`
        : `${where.textContent}; ${count(found)} event${found === 1 ? '' : 's'} about ${text}`;
  };

  // Time axis.

  const colours = () => getComputedStyle(document.documentElement);
  const fit = (canvas) => {
    const scale = devicePixelRatio || 1,
      width = canvas.clientWidth,
      height = canvas.clientHeight;
    if (canvas.width !== Math.round(width * scale) || canvas.height !== Math.round(height * scale)) {
      canvas.width = Math.round(width * scale);
      canvas.height = Math.round(height * scale);
    }
    const pen = canvas.getContext('2d');
    pen.setTransform(scale, 0, 0, scale, 0, 0);
    pen.clearRect(0, 0, width, height);
    return { pen, width, height };
  };
  const axis_ends = () =>
    nodes().timeline.reduce(([from, to], slice) => [Math.min(from, slice[2]), Math.max(to, slice[3])], [Infinity, -Infinity]);
  const draw_axis = () => {
    const slices = nodes().timeline;
    axis.hidden = slices.length === 0;
    if (axis.hidden) return;
    const { pen, width } = fit(axis_canvas),
      style = colours();
    const [from, to] = axis_ends(),
      x = (cycle) => ((cycle - from) / Math.max(1, to - from)) * width;
    const names = [...new Set(slices.filter(([name]) => name !== '').map(([name]) => name))];
    const now = place_of(position).r,
      sums = new Map();
    pen.font = `12px ${getComputedStyle(document.body).fontFamily}`;
    for (const [name, round, begin, end] of slices) {
      if (name === '') {
        pen.fillStyle = style.getPropertyValue(round === now ? '--accent' : '--shade');
        pen.fillRect(x(begin), 0, Math.max(1, x(end) - x(begin) - 1), 20);
        pen.fillStyle = style.getPropertyValue(round === now ? '--card' : '--ink');
        if (x(end) - x(begin) > 18 && round < page.rays[ray].rounds.length) pen.fillText(String(round), x(begin) + 4, 14);
      } else {
        pen.fillStyle = style.getPropertyValue(`--c${(names.indexOf(name) % 12) + 1}`);
        pen.fillRect(x(begin), 24, Math.max(0.6, x(end) - x(begin)), 14);
        sums.set(name, (sums.get(name) || 0) + end - begin);
      }
    }
    pen.fillStyle = style.getPropertyValue('--muted');
    pen.fillText(`cycle ${count(from)}`, 0, 54);
    pen.textAlign = 'right';
    pen.fillText(`cycle ${count(to)}`, width, 54);
    pen.textAlign = 'left';
    axis_canvas.setAttribute('aria-label', `Rounds of the warp between cycle ${count(from)} and ${count(to)}`);
    const swatch = (i) => `<span class="swatch" style="background:var(--c${(i % 12) + 1})"></span>`;
    const legend = (name, i) => `<span>${swatch(i)}${safe(name.replaceAll('_', ' '))} ${count(sums.get(name))} cycles</span>`;
    axis_text.innerHTML = names.map(legend).join('');
  };
  axis_canvas.addEventListener('click', (event) => {
    const [from, to] = axis_ends(),
      cycle = from + (event.offsetX / axis_canvas.clientWidth) * (to - from);
    const slice = nodes().timeline.find(([name, , begin, end]) => name === '' && begin <= cycle && cycle < end);
    if (slice && slice[1] < page.rays[ray].rounds.length) go_to(offsets[slice[1]]);
  });

  // What the ray met: the hits that its rounds looked at, with the share of the pixel that each gives.

  const ticks = (low, high, most) => {
    const rough = (high - low) / most,
      power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((f) => f * power).find((s) => s >= rough) || 10 * power;
    const list = [];
    for (let n = Math.ceil(low / step); n * step <= high && list.length < 100; n += 1) list.push(n * step);
    return list;
  };
  // Alpha of a Gaussian for the ray: its response where the ray passes nearest to the centre, in standard deviations.
  const alpha_of = (gaussian) => {
    const s = shape(gaussian),
      { origin, direction } = page.rays[ray];
    if (s === null) return 0;
    const [a, b, c] = [3, 6, 9].map((i) => s.subarray(i, i + 3));
    const cross = (u, v) => [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const dot = (u, v) => u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    const size = dot(a, cross(b, c));
    const local = (v) => [dot(v, cross(b, c)) / size, dot(v, cross(c, a)) / size, dot(v, cross(a, b)) / size];
    const from = local(origin.map((v, i) => v - s[i])),
      along = local(direction);
    const t = -dot(from, along) / dot(along, along),
      near = from.map((v, i) => v + t * along[i]);
    const sigma2 = dot(near, near) * s[16] ** 2;
    return Math.min(0.99, s[15] * Math.exp(page.kernel_degree === 4 ? -(sigma2 ** 2) / 18 : -sigma2 / 2));
  };
  const hit_lists = new Map();
  let hits_run = 0;
  const find_hits = async () => {
    const own = ray,
      run = ++hits_run,
      list = [],
      all = page.rays[own].rounds.length;
    let light = 1,
      began = performance.now();
    for (let r = 0; r < all && page.rays[own].values && !hit_lists.has(own); r += 1) {
      const round = round_of(own, r),
        kept = state_at(round, round.events - 1).k;
      if (unsorted) kept.sort((a, b) => a.t - b.t);
      kept.slice(0, summary(r).processed).forEach((hit) => {
        const alpha = alpha_of(hit.gaussian - 1);
        list.push({ r, t: hit.t, gaussian: hit.gaussian - 1, alpha, share: light * alpha });
        light *= 1 - alpha;
      });
      if (performance.now() - began > 30) {
        // the page stays alive
        await new Promise((resolve) => {
          setTimeout(resolve);
        });
        if (run !== hits_run) return;
        began = performance.now();
      }
    }
    if (!hit_lists.has(own)) hit_lists.set(own, list);
    tell_story();
    draw_hits();
  };
  const hits = () => hit_lists.get(ray) || [];

  // A paragraph: what the ray did.
  const tell_story = () => {
    const own = page.rays[ray],
      all = own.rounds;
    const sum = (what) => all.reduce((total_of, s) => total_of + what(s), 0);
    const read = sum((s) => s.visits[0] + s.visits[1] + s.visits[2]),
      met = sum((s) => s.processed),
      blended = sum((s) => s.blended);
    const again = all.filter((s) => s.replay).length,
      last = all[all.length - 1];
    const took = `took ${count(all.length)} round${all.length === 1 ? '' : 's'}, read ${count(read)} nodes`;
    const words = [`The ray of ${own.name} ${took} and looked at ${count(met)} hits, of which ${count(blended)} were blended.`];
    if (all.length > 1) {
      const first = (all[0].visits[0] + all[0].visits[1] + all[0].visits[2]) / Math.max(1, read);
      const which = again === all.length - 1 ? 'All rounds but the first' : `${count(again)} rounds`;
      const began = again > 0 ? `${which} went on from checkpoints` : 'Each round began at the root again';
      words.push(`${began}; the first read ${Math.round(100 * first)} % of the nodes.`);
    }
    if (last && last.terminated) words.push('It ended because it was opaque.');
    else if (last && own.values) words.push(`It left the scene with ${time(100 * last.transmittance)} % of its light.`);
    const most = hits().reduce((best, hit) => (best === null || hit.share > best.share ? hit : best), null);
    if (most !== null && most.share > 0) {
      const place = `Gaussian ${most.gaussian} at t = ${time(most.t)}, met in round ${most.r}`;
      words.push(`Most of the pixel, ${Math.round(100 * most.share)} %, is ${place}.`);
    }
    story.textContent = words.join(' ');
  };
  const show_pixel = () => {
    const [width, height] = page.size,
      [px, py] = page.rays[ray].pixel;
    const mark = element('span', { className: 'mark' });
    mark.style.left = `${((px + 0.5) / width) * 100}%`;
    mark.style.top = `${((py + 0.5) / height) * 100}%`;
    const ground = element(
      'div',
      { className: 'ground' },
      ...(page.picture ? [element('img', { src: page.picture, alt: 'The picture of the view' })] : []),
      mark,
    );
    if (!page.picture) ground.style.aspectRatio = `${width} / ${height}`;
    pixel_box.replaceChildren(
      ground,
      element('figcaption', {
        textContent: `pixel ${px},${py} of ${width} × ${height}${page.picture ? '' : '; --image shows the picture'}`,
      }),
    );
  };

  // Stems at t, as high as their share; rounds are bands; the dashed line is the light that is left.
  const hits_scale = () => {
    const list = hits(),
      ends = list.map((hit) => hit.t);
    const low = Math.min(...ends),
      high = Math.max(...ends),
      margin = 0.03 * (high - low) || 0.05 * high || 1;
    return { low: low - margin, high: high + margin, most: Math.max(...list.map((hit) => hit.share), 1e-6) };
  };
  const kHitsFoot = 22,
    kHitsHead = 20;
  const draw_bands = (pen, style, x, height) => {
    const now = shown === null ? -1 : shown.r,
      bands = new Map();
    for (const hit of hits()) {
      const band = bands.get(hit.r) || [hit.t, hit.t];
      bands.set(hit.r, [Math.min(band[0], hit.t), Math.max(band[1], hit.t)]);
    }
    for (const [r, [from, to]] of bands) {
      const left = x(from) - 3,
        wide = Math.max(6, x(to) - x(from) + 6);
      pen.globalAlpha = r === now ? 1 : r % 2 === 0 ? 0.55 : 0.25;
      pen.fillStyle = style.getPropertyValue(r === now ? '--chosen' : '--shade');
      pen.fillRect(left, 0, wide, height - kHitsFoot);
      pen.globalAlpha = 1;
      pen.fillStyle = style.getPropertyValue(r === now ? '--ink' : '--muted');
      if (wide > 16 || r === now) pen.fillText(wide > 60 ? `round ${r}` : String(r), left + 3, 13);
    }
  };
  const draw_stems = (pen, style, x, y, height) => {
    const { event } = shown,
      just = event !== null && event.hit !== null ? event.hit.gaussian - 1 : -1;
    pen.setLineDash([4, 3]);
    pen.strokeStyle = style.getPropertyValue('--muted');
    pen.lineWidth = 1;
    pen.beginPath();
    let light = 1;
    const light_y = () => height - kHitsFoot - light * (height - kHitsFoot - kHitsHead);
    pen.moveTo(0, light_y());
    for (const hit of hits()) {
      pen.lineTo(x(hit.t), light_y());
      light *= 1 - hit.alpha;
      pen.lineTo(x(hit.t), light_y());
    }
    pen.stroke();
    pen.setLineDash([]);
    for (const hit of hits()) {
      const s = shape(hit.gaussian),
        top = y(hit.share),
        wide = hit.gaussian === just ? 7 : 4;
      pen.fillStyle =
        s === null ? style.getPropertyValue('--c8') : `rgb(${[s[12], s[13], s[14]].map((c) => Math.round(255 * c)).join(',')})`;
      pen.strokeStyle = style.getPropertyValue(hit.gaussian === just ? '--accent' : '--ink');
      pen.lineWidth = hit.gaussian === just ? 2 : 0.7;
      pen.beginPath();
      pen.rect(x(hit.t) - wide / 2, top, wide, Math.max(2, height - kHitsFoot - top));
      pen.fill();
      pen.stroke();
    }
  };
  const draw_hits = () => {
    hits_box.hidden = hits().length === 0;
    if (hits_box.hidden || shown === null) return;
    const { pen, width, height } = fit(hits_canvas),
      style = colours(),
      { low, high, most } = hits_scale();
    const x = (t) => ((t - low) / (high - low)) * width,
      y = (share) => height - kHitsFoot - (share / most) * (height - kHitsFoot - kHitsHead);
    pen.font = `12px ${getComputedStyle(document.body).fontFamily}`;
    draw_bands(pen, style, x, height);
    draw_stems(pen, style, x, y, height);
    pen.fillStyle = style.getPropertyValue('--muted');
    pen.fillRect(0, height - kHitsFoot, width, 1);
    for (const t of ticks(low, high, Math.max(2, width / 90))) {
      pen.fillRect(x(t), height - kHitsFoot, 1, 4);
      pen.fillText(`t ${time(t)}`, Math.max(0, Math.min(width - 40, x(t) - 12)), height - 5);
    }
    const { r, i, round } = shown,
      t_max = i < 0 ? round.first_t_max : round.t_max[i];
    if (Number.isFinite(t_max) && t_max >= low && t_max <= high) {
      pen.fillStyle = style.getPropertyValue('--bad');
      pen.fillRect(x(t_max) - 1, 0, 2, height - kHitsFoot);
      pen.fillText('t_max', Math.min(width - 34, x(t_max) + 4), 30);
    }
    const tallest = `gives ${Math.round(100 * most)} % of the pixel`,
      span = `${hits().length} hits between t = ${time(low)} and ${time(high)}`;
    hits_canvas.setAttribute('aria-label', `${span}; the tallest ${tallest}; now round ${r}`);
    const help = 'Dashed: the light that is left. Point at a hit; click, or arrows, to go to it.';
    if (hits_text.textContent === '') hits_text.textContent = `The tallest ${tallest}. ${help}`;
  };
  const hit_text = (hit) =>
    `Gaussian ${hit.gaussian} at t = ${time(hit.t)}, round ${hit.r}: ` +
    `alpha ${time(hit.alpha)}, gives ${time(100 * hit.share)} % of the pixel.`;
  const hit_at = (event) => {
    const { low, high } = hits_scale(),
      t = low + (event.offsetX / hits_canvas.clientWidth) * (high - low);
    return hits().reduce((best, hit) => (best === null || Math.abs(hit.t - t) < Math.abs(best.t - t) ? hit : best), null);
  };
  const go_to_hit = (hit) => {
    const round = round_of(ray, hit.r);
    let found = -1;
    for (let i = 0; i < round.events; i += 1) if (round.gaussian[i] === hit.gaussian + 1 && round.noted[i] === 2) found = i;
    go_to(offsets[hit.r] + 1 + found);
    hits_text.textContent = hit_text(hit);
  };
  let hit_place = -1;
  hits_canvas.addEventListener('pointermove', (event) => {
    const hit = hit_at(event);
    if (hit !== null) hits_text.textContent = hit_text(hit);
  });
  hits_canvas.addEventListener('click', (event) => {
    const hit = hit_at(event);
    if (hit === null) return;
    hit_place = hits().indexOf(hit);
    go_to_hit(hit);
  });
  hits_canvas.addEventListener('keydown', (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step || hits().length === 0) return;
    hit_place = Math.max(0, Math.min(hits().length - 1, hit_place + step));
    go_to_hit(hits()[hit_place]);
    event.preventDefault();
    event.stopPropagation();
  });

  // View of boxes and Gaussians: from the side of the ray, which runs from left to right.

  const view_canvas = element('canvas', {
    tabIndex: 0,
    role: 'img',
    'aria-label': 'Boxes and Gaussians that the ray met, seen from its side',
  });
  const what_boxes = element(
    'select',
    { 'aria-label': 'Boxes shown' },
    ...[
      ['node', 'the node'],
      ['path', 'way to the node'],
      ['round', 'all read so far in the round'],
      ['none', 'no boxes'],
    ].map(([value, textContent]) => element('option', { value, textContent })),
  );
  let turn = 0,
    tilt = 0.25,
    zoom = 1,
    centre = 0,
    reach = 1;
  const has_values = page.rays.some((r) => r.values);
  if (has_values) {
    view_box.hidden = false;
    view_box.append(
      element('h2', {}, 'Boxes and Gaussians'),
      view_canvas,
      element(
        'div',
        { className: 'controls' },
        element('label', {}, 'boxes ', what_boxes),
        button('reset', 'Reset the view', () => {
          reset_view();
          draw_view();
        }),
        element('span', {
          className: 'note',
          textContent:
            'Left to right: along the ray. Filled: in the k-buffer; red: evicted; blue: just hit. Drag or arrows turn, + and - zoom.',
        }),
      ),
    );
    what_boxes.onchange = () => draw_view();
  }
  const basis = () => {
    const d = page.rays[ray].direction,
      length = Math.hypot(...d) || 1;
    const x = d.map((c) => c / length),
      helper = Math.abs(x[1]) < 0.9 ? [0, 1, 0] : [1, 0, 0];
    const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    const z = cross(x, helper),
      size = Math.hypot(...z);
    for (let i = 0; i < 3; i += 1) z[i] /= size;
    return [x, cross(z, x), z];
  };
  const reset_view = () => {
    turn = 0;
    tilt = 0.25;
    zoom = 1;
    if (!page.rays[ray].values) return;
    // Ends where most of the hits that a round kept lie.
    const times = [];
    const rounds_looked_at = Math.min(page.rays[ray].rounds.length, 8);
    for (let r = 0; r < rounds_looked_at; r += 1) {
      const round = round_of(ray, r);
      for (const hit of [...round.evictions, ...state_at(round, round.events - 1).k]) {
        if (Number.isFinite(hit.t)) times.push(hit.t);
      }
    }
    times.sort((a, b) => a - b);
    const nearest = times.length > 0 ? times[0] : 0;
    const last = times.length > 0 ? times[Math.floor((times.length > 10 ? 0.9 : 1) * (times.length - 1))] : 1;
    const margin = Math.max(0.12 * (last - nearest), 1e-3 * last);
    centre = (nearest + last) / 2;
    reach = (last - nearest) / 2 + 2 * margin;
  };
  // What the view is drawn with: the projection, and the pen on it.
  const limit = (v) => Math.max(-1e5, Math.min(1e5, v));
  const in_gaussian = (s, p) => [0, 1, 2].map((i) => s[i] + s[3 + i] * p[0] + s[6 + i] * p[1] + s[9 + i] * p[2]);
  const view_tools = () => {
    const { pen, width, height } = fit(view_canvas),
      style = colours(),
      [x, y, z] = basis(),
      { origin, direction } = page.rays[ray];
    const scale = (zoom * width) / (2 * reach);
    const along = (p, axis) => (p[0] - origin[0]) * axis[0] + (p[1] - origin[1]) * axis[1] + (p[2] - origin[2]) * axis[2];
    const place = (p) => {
      const a = along(p, x) - centre,
        b = along(p, y),
        c = along(p, z);
      const a2 = a * Math.cos(turn) + c * Math.sin(turn),
        c2 = c * Math.cos(turn) - a * Math.sin(turn);
      return [width / 2 + a2 * scale, height / 2 - (b * Math.cos(tilt) - c2 * Math.sin(tilt)) * scale];
    };
    const on_ray = (t) => place(origin.map((c, i) => c + direction[i] * t));
    const line = (from, to, name, thick) => {
      pen.strokeStyle = style.getPropertyValue(name);
      pen.lineWidth = thick;
      pen.beginPath();
      pen.moveTo(limit(from[0]), limit(from[1]));
      pen.lineTo(limit(to[0]), limit(to[1]));
      pen.stroke();
    };
    pen.font = `12px ${getComputedStyle(document.body).fontFamily}`;
    return { pen, style, place, on_ray, line };
  };
  const draw_box = ({ place, line }, node, colour, thick, entry) => {
    const b = nodes().box.subarray(6 * node, 6 * node + 6);
    if (b.length === 0 || Number.isNaN(b[0])) return;
    const inside = in_blas(node),
      s = inside ? shape(gaussian_of(entry) - 1) : null;
    if (inside && s === null) return;
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => {
      const p = [b[i & 1 ? 3 : 0], b[i & 2 ? 4 : 1], b[i & 4 ? 5 : 2]];
      return place(inside ? in_gaussian(s, p) : p);
    });
    for (let i = 0; i < 8; i += 1) for (const bit of [1, 2, 4]) if ((i & bit) === 0) line(corners[i], corners[i | bit], colour, thick);
  };
  // The outline of an ellipsoid under a parallel projection is an ellipse: rows of the projection times its half axes.
  const draw_ellipsoid = ({ pen, style, place }, gaussian, colour, filled, label) => {
    const s = shape(gaussian);
    if (s === null) return;
    const zero = place(in_gaussian(s, [0, 0, 0]));
    const axes = [0, 1, 2].map((axis) =>
      place(
        in_gaussian(
          s,
          [0, 1, 2].map((i) => (i === axis ? 1 : 0)),
        ),
      ).map((v, i) => v - zero[i]),
    );
    const sum = (of) => axes.reduce((all, a) => all + of(a), 0);
    const xx = sum((a) => a[0] * a[0]),
      xy = sum((a) => a[0] * a[1]),
      yy = sum((a) => a[1] * a[1]);
    const middle = (xx + yy) / 2,
      spread = Math.hypot((xx - yy) / 2, xy);
    const radii = [middle + spread, middle - spread].map((v) => Math.min(1e5, Math.sqrt(Math.max(0, v))));
    pen.beginPath();
    pen.ellipse(limit(zero[0]), limit(zero[1]), ...radii, Math.atan2(2 * xy, xx - yy) / 2, 0, 2 * Math.PI);
    if (filled) {
      pen.globalAlpha = Math.max(0.15, 0.45 * s[15]);
      pen.fillStyle = `rgb(${[s[12], s[13], s[14]].map((c) => Math.round(255 * c)).join(',')})`;
      pen.fill();
      pen.globalAlpha = 1;
    }
    pen.strokeStyle = style.getPropertyValue(colour);
    pen.lineWidth = filled ? 1.6 : 1;
    pen.stroke();
    if (!label) return;
    pen.fillStyle = style.getPropertyValue('--ink');
    pen.fillText(String(gaussian), limit(zero[0]) + 3, limit(zero[1] - Math.sqrt(yy)) - 3);
  };
  const draw_boxes = (tools) => {
    const { event, round, i } = shown,
      which = what_boxes.value;
    for (let e = Math.max(0, i - 2000); which === 'round' && e <= i; e += 1) {
      if (round.look[e] < 3 && !in_blas(round.node[e])) draw_box(tools, round.node[e], '--line', 1, null);
    }
    if (event === null || which === 'none') return;
    const entry = event.popped || (event.pushed.length > 0 ? event.pushed[0] : { node: event.node, instance: 0, object: 0 });
    for (let node = nodes().parent[event.node]; node !== 0 && which === 'path'; node = nodes().parent[node - 1]) {
      draw_box(tools, node - 1, '--line', 1, entry);
    }
    for (const child of event.pushed) draw_box(tools, child.node, '--c1', 1, child);
    for (const child of event.written) draw_box(tools, child.node, '--c9', 1.4, child);
    draw_box(tools, event.node, '--accent', 2, entry);
    if (entry.instance !== 0) draw_box(tools, entry.instance - 1, '--accent', 1, entry);
  };
  const draw_ray = ({ pen, style, on_ray, line }) => {
    for (const t of ticks(Math.max(0, centre - reach / zoom), centre + reach / zoom, 8)) {
      const [px, py] = on_ray(t);
      line([px, py - 4], [px, py + 4], '--muted', 1);
      pen.fillStyle = style.getPropertyValue('--ink');
      pen.fillText(`t ${time(t)}`, limit(px) - 12, limit(py) + 18);
    }
    const { round, i } = shown,
      t_max = i < 0 ? round.first_t_max : round.t_max[i];
    if (!Number.isFinite(t_max)) return;
    const [px, py] = on_ray(t_max);
    line([px, py - 26], [px, py + 26], '--bad', 2);
    pen.fillStyle = style.getPropertyValue('--bad');
    pen.fillText(`t_max ${time(t_max)}`, limit(px) + 4, limit(py) + 34);
  };
  const draw_view = () => {
    if (view_box.hidden || shown === null || !page.rays[ray].values) return;
    const tools = view_tools(),
      { pen, style, on_ray, line } = tools,
      { event, round, i } = shown;
    line(on_ray(0), on_ray(centre + (3 * reach) / Math.min(zoom, 1)), '--ink', 1);
    draw_boxes(tools);
    const evicted = until(round.evicted_at, i);
    for (let e = Math.max(0, evicted - 200); e < evicted; e += 1) {
      draw_ellipsoid(tools, round.evictions[e].gaussian - 1, '--c4', false, evicted <= 12);
    }
    for (const hit of shown.k.slice(0, 256)) draw_ellipsoid(tools, hit.gaussian - 1, '--c3', true, shown.k.length <= 16);
    if (event !== null && event.hit !== null) draw_ellipsoid(tools, event.hit.gaussian - 1, '--accent', false, true);
    for (const hit of shown.k.slice(0, 256)) {
      const [px, py] = on_ray(hit.t);
      pen.fillStyle = style.getPropertyValue('--ink');
      pen.fillRect(limit(px) - 1, limit(py) - 4, 2, 8);
    }
    draw_ray(tools);
  };
  let drag = null;
  view_canvas.addEventListener('pointerdown', (event) => {
    drag = [event.clientX, event.clientY];
    view_canvas.setPointerCapture(event.pointerId);
  });
  view_canvas.addEventListener('pointermove', (event) => {
    if (drag === null) return;
    turn += (event.clientX - drag[0]) * 0.01;
    tilt += (event.clientY - drag[1]) * 0.01;
    drag = [event.clientX, event.clientY];
    draw_view();
  });
  view_canvas.addEventListener('pointerup', () => {
    drag = null;
  });
  view_canvas.addEventListener(
    'wheel',
    (event) => {
      event.preventDefault();
      zoom *= Math.exp(-event.deltaY * 0.001);
      draw_view();
    },
    { passive: false },
  );
  view_canvas.addEventListener('keydown', (event) => {
    const moves = {
      ArrowLeft: () => {
        turn -= 0.1;
      },
      ArrowRight: () => {
        turn += 0.1;
      },
      ArrowUp: () => {
        tilt -= 0.1;
      },
      ArrowDown: () => {
        tilt += 0.1;
      },
      '+': () => {
        zoom *= 1.25;
      },
      '=': () => {
        zoom *= 1.25;
      },
      '-': () => {
        zoom /= 1.25;
      },
    };
    if (!moves[event.key]) return;
    moves[event.key]();
    event.preventDefault();
    event.stopPropagation();
    draw_view();
  });

  // Keys of the page.

  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const tag = event.target.tagName;
    if (tag === 'SELECT' || tag === 'SUMMARY' || (tag === 'INPUT' && event.target !== slider)) return;
    if (tag === 'BUTTON' && (event.key === ' ' || event.key === 'Enter')) return;
    const actions = {
      ArrowRight: () => go_to(position + 1),
      ArrowLeft: () => go_to(position - 1),
      Home: () => go_to(0),
      End: () => go_to(total() - 1),
      n: () => next_noted(1),
      p: () => next_noted(-1),
      '[': () => next_round(-1),
      ']': () => next_round(1),
      ' ': toggle_play,
      '/': () => search.focus(),
    };
    if (!actions[event.key]) return;
    event.preventDefault();
    actions[event.key]();
  });
  search.addEventListener('keydown', (event) => {
    if (event.key === 'Enter') find();
    else if (event.key === 'Escape') search.blur();
  });
  speed.addEventListener('change', () => {
    if (playing !== null) {
      toggle_play();
      toggle_play();
    }
  });
  slider.addEventListener('input', () => go_to(Number(slider.value)));
  fold.addEventListener('change', () => {
    for (const round of rounds.values()) {
      round.rows = null;
      round.open.clear();
    }
    go_to(position);
  });
  strip.addEventListener('scroll', draw_strip);
  addEventListener('resize', () => {
    go_to(position);
  });
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
    draw_axis();
    draw_hits();
    draw_view();
  });

  const choose_ray = (chosen) => {
    if (playing !== null) toggle_play();
    ray = chosen;
    for (const column of columns.values()) column.box.remove();
    columns.clear();
    offsets = [0];
    for (const round of page.rays[ray].rounds) offsets.push(offsets[offsets.length - 1] + round.events + 1);
    slider.max = total() - 1;
    strip.scrollLeft = 0;
    reset_view();
    hits_text.textContent = '';
    go_to(0);
    tell_story();
    show_pixel();
    find_hits();
  };
  ray_choice.addEventListener('change', () => {
    rounds.clear();
    choose_ray(Number(ray_choice.value));
  });
  choose_ray(0);
  document.documentElement.dataset.ready = '1';
})();
