// SPDX-License-Identifier: Apache-2.0
// The rows of a round: an event each; parts of the tree in which nothing happened are folded to one.
import { count, element, safe, time } from './dom.js';
import { looks } from './events.js';
import { node_name } from './nodes.js';

export const fold = element(
  'select',
  { 'aria-label': 'What is folded' },
  element('option', { value: 2, textContent: 'no hit' }),
  element('option', { value: 1, textContent: 'no hit, no checkpoint' }),
  element('option', { value: 0, textContent: 'nothing' }),
);

// [2 row] the row's first event, [2 row + 1] the one behind its last.
export const rows_of = (round) => {
  if (round.rows !== null) return round.rows;
  const level = Number(fold.value),
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
export const row_of = (round, i) => {
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
export const unfold = (round, i) => {
  round.open.add(i);
  round.rows = null;
};
// Folds the run of events that was unfolded and that event i is in.
export const fold_again = (round, i) => {
  let run = -1;
  for (const opened of round.open) if (opened <= i && opened > run) run = opened;
  round.open.delete(run);
  round.rows = null;
};

// Whole, where a row has no room.
const row_title = (round, i) => {
  const known = round.gaussian[i] !== 0 ? `, Gaussian ${round.gaussian[i] - 1}` : '';
  return `${node_name(round.node[i])}${known}, ${looks[round.look[i]].name}`;
};
const folded_text = (round, begin, end) => {
  let read = 0,
    kept = 0;
  for (let i = begin; i < end; i += 1) {
    read += looks[round.look[i]].reads ? 1 : 0;
    kept += round.noted[i] === 1 ? 1 : 0;
  }
  const parts = read > 0 ? [`${count(read)} node${read === 1 ? '' : 's'} without a hit`] : [];
  if (read < end - begin) parts.push(`${count(end - begin - read)} not read`);
  if (kept > 0) parts.push(`${count(kept)} checkpointed`);
  return parts.join(', ');
};
const row_text = (round, i) => {
  const { name, outcome } = looks[round.look[i]],
    node = node_name(round.node[i]);
  const known = round.gaussian[i] !== 0 ? `G ${round.gaussian[i] - 1}` : '';
  const beside = (text) => `${node} <span class="m">${text}</span>`;
  if (outcome !== undefined && name !== 'miss') {
    const at = round.values && !Number.isNaN(round.time[i]) ? ` at ${time(round.time[i])}` : '';
    return `${name} ${known}${at} <span class="m">${node}</span>`;
  }
  if (name === 'miss') return beside('miss');
  if (name === 'cull') return beside('not read: beyond t_max');
  if (name === 'take' || name === 'forward') return `${name} ${node}`;
  return beside(round.transforms[i] === 1 ? `transform ${known}` : known);
};
// now: the place that the page is at.
export const write_row = (round, r, now, row, style) => {
  const rows = rows_of(round),
    i = rows[2 * row],
    end = rows[2 * row + 1];
  const chosen = now.r === r && now.i >= i && now.i < end;
  const indent = '<span class="i"></span>'.repeat(Math.min(round.depth[i], 16));
  const mark = chosen ? ' now' : '';
  const title = end - i > 1 ? '' : safe(row_title(round, i));
  const open = `style="${style}" title="${title}" role="option" id="e${r}_${i}" data-event="${i}" aria-selected="${chosen}"`;
  if (end - i > 1) return `<div class="row fold${mark}" ${open} data-fold="1">${indent}▸ ${folded_text(round, i, end)}</div>`;
  return `<div class="row k-${looks[round.look[i]].name}${mark}" ${open}>${indent}<span class="dot"></span>${row_text(round, i)}</div>`;
};
