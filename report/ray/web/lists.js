// SPDX-License-Identifier: Apache-2.0
// The lists of the state that is shown. Evictions and checkpoints are shown by their t, with their place in the list
// before it.
import { count, element, hex, safe, time, until } from './dom.js';
import { List } from './list.js';
import { gaussian_name, gaussian_of, node_name, nodes } from './nodes.js';
import { page, several } from './page.js';
import { shown } from './position.js';

const kMostSorted = 4096;

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
    (entry.under_way ? ' <span class="m">under way</span>' : '');
  return list_row(number, style, look, `data-node="${address}"`, title, text, entry.t);
};

class Panel {
  // row(row, style): HTML of a row.
  constructor(id, title, row, tall = false) {
    this.note = element('span');
    const box = element('div', { className: tall ? 'list tall' : 'list', tabIndex: 0, role: 'list', 'aria-label': title });
    this.section = element('section', { id }, element('h2', {}, title, this.note), box);
    this.list = new List(box, row);
  }
  show(note, rows, revealed = -1) {
    this.note.textContent = note;
    this.list.show(rows);
    if (revealed >= 0) this.list.reveal(revealed);
  }
}

// By t where it is known.
const by_time = (list, length) => {
  const order = Array.from({ length }, (unused, i) => i);
  return shown.round.values && length <= kMostSorted ? order.sort((a, b) => list[a].t - list[b].t || a - b) : order;
};
const orders = { evictions: [], source: [], destination: [] };

const k_panel = new Panel(
  'k_buffer',
  'k-buffer',
  (row, style) => hit_row(row, shown.k[row], style, shown.event !== null && shown.event.place === row ? ' new' : ''),
  true,
);
const eviction_panel = new Panel('evictions', 'Eviction list', (row, style) => {
  const at = orders.evictions[row];
  return hit_row(at, shown.round.evictions[at], style, shown.round.evicted_at[at] === shown.i && shown.i >= 0 ? ' new' : '');
});
const stack_panel = new Panel('stack', 'Stack', (row, style) => {
  const entry = shown.stack[shown.stack.length - 1 - row];
  return node_row(row, entry, style, shown.event !== null && shown.event.pushed.includes(entry) ? ' new' : '');
});
const source_panel = new Panel('source', 'Source list', (row, style) => {
  const at = orders.source[row],
    read = shown.round.read_at[at];
  return node_row(at, shown.round.source[at], style, read === shown.i ? ' new' : read < shown.i ? ' gone' : '');
});
const destination_panel = new Panel('destination', 'Destination list', (row, style) => {
  const at = orders.destination[row];
  return node_row(at, shown.round.destination[at], style, shown.round.destination_at[at] === shown.i ? ' new' : '');
});
for (const { section } of [eviction_panel, source_panel, destination_panel]) section.hidden = !page.checkpoint;
export const panels = [
  k_panel.section,
  element('div', { className: 'pair-of-lists' }, eviction_panel.section, stack_panel.section),
  element('div', { className: 'pair-of-lists' }, source_panel.section, destination_panel.section),
];

export const show_lists = () => {
  const { k, stack, round, event, i } = shown;
  const last = i === round.events - 1 ? ', sorted when the round ends' : ', a heap: in order of arrival';
  const place = event !== null ? event.place : -1;
  k_panel.show(`${k.length} of ${page.k}${page.sorted ? '' : last}`, page.k <= 64 ? page.k : k.length, place);
  const evicted = until(round.evicted_at, i),
    written = until(round.destination_at, i);
  orders.evictions = by_time(round.evictions, evicted);
  orders.source = by_time(round.source, round.source.length);
  orders.destination = by_time(round.destination, written);
  eviction_panel.show(count(evicted), evicted, orders.evictions.indexOf(evicted - 1));
  const under_way = stack.filter((entry) => entry.under_way).length;
  stack_panel.show(count(stack.length) + (several ? `, ${under_way} under way` : ''), stack.length);
  let left = 0;
  for (const at of round.read_at) left += at > i ? 1 : 0;
  const read = event !== null ? event.read : -1;
  source_panel.show(`${count(left)} of ${count(round.source.length)}`, round.source.length, orders.source.indexOf(read));
  destination_panel.show(count(written), written, orders.destination.indexOf(written - 1));
};
