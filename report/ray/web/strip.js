// SPDX-License-Identifier: Apache-2.0
// Rounds side by side, each a column with its events; only those in sight are elements.
import { count, counted, element, safe, time } from './dom.js';
import { List } from './list.js';
import { nodes, ray, ray_number } from './nodes.js';
import { page } from './page.js';
import { go_to_event, here, place_of, shown, summary } from './position.js';
import { fold_again, row_of, rows_of, unfold, write_row } from './rows.js';
import { round_of } from './rounds.js';

export const strip = element('div', { className: 'strip', tabIndex: -1 });
const inside = element('div');
strip.append(inside);
const columns = new Map();

const column_width = () =>
  strip.clientWidth < 520 ? strip.clientWidth : Math.floor(strip.clientWidth / Math.max(2, Math.floor(strip.clientWidth / 330)));
const head_text = (r) => {
  const s = summary(r);
  const parts = [
    `${counted(s.events, 'event')}, ${counted(s.read, 'node')} read`,
    `k-buffer ${s.preloaded > 0 ? `${s.preloaded} preloaded, ` : ''}${counted(s.hits, 'hit')}, ${s.blended} blended`,
  ];
  if (page.checkpoint) parts.push(`checkpoints ${s.taken} taken, ${s.forwarded} forwarded, ${s.written} written; ${s.evicted} evicted`);
  if (s.transmittance !== undefined) parts.push(`light let through ${time(s.transmittance)}`);
  const span = nodes().timeline.find(([name, round]) => name === '' && round === r);
  if (span) parts.push(`cycles ${count(span[2])} to ${count(span[3])}`);
  const end = s.terminated ? ', ends the ray' : s.overflow ? ', list ran full' : '';
  return `<b>Round ${r}</b> from ${s.replay ? 'its checkpoints' : 'the root'}${end}<br>${parts.map(safe).join('<br>')}`;
};

const step_in_list = (event, r) => {
  const round = round_of(ray_number(), r),
    now = place_of(here());
  const row = now.r === r && now.i >= 0 ? row_of(round, now.i) : -1;
  const rows = rows_of(round);
  if (event.key === 'ArrowDown' || event.key === 'ArrowUp') {
    const next = Math.max(0, Math.min(rows.length / 2 - 1, row + (event.key === 'ArrowDown' ? 1 : -1)));
    if (rows.length > 0) go_to_event(r, rows[2 * next]);
  } else if (event.key === 'Enter' && row >= 0) {
    const begin = rows[2 * row];
    if (rows[2 * row + 1] - begin > 1) unfold(round, begin);
    else fold_again(round, begin);
    draw_strip();
    columns.get(r).list.reveal(row_of(round, now.i));
  } else {
    return;
  }
  event.preventDefault();
  event.stopPropagation();
};
const click_in_list = (event, r) => {
  const row = event.target.closest('.row');
  if (!row) return;
  const i = Number(row.dataset.event);
  if (row.dataset.fold === '1') unfold(round_of(ray_number(), r), i);
  go_to_event(r, i);
};
const make_column = (r) => {
  const round = round_of(ray_number(), r);
  const head = element('header');
  head.innerHTML = head_text(r);
  const box = element('div', { className: 'list', tabIndex: 0, role: 'listbox', 'aria-label': `Events of round ${r}` });
  const column = { round, box: element('div', { className: 'round' }, head, box) };
  inside.append(column.box);
  column.list = new List(box, (row, style) => write_row(round, r, place_of(here()), row, style));
  box.addEventListener('click', (event) => click_in_list(event, r));
  box.addEventListener('keydown', (event) => step_in_list(event, r));
  columns.set(r, column);
  return column;
};

export const draw_strip = () => {
  const width = column_width(),
    all = ray().rounds.length;
  inside.style.width = `${width * all}px`;
  inside.style.height = `${Math.max(420, Math.min(760, innerHeight - 140))}px`;
  const first = Math.max(0, Math.floor(strip.scrollLeft / width)),
    last = Math.min(all - 1, Math.floor((strip.scrollLeft + strip.clientWidth - 1) / width));
  for (const [r, column] of columns) {
    if (r >= first && r <= last) continue;
    column.box.remove();
    columns.delete(r);
  }
  const now = place_of(here());
  for (let r = first; r <= last; r += 1) {
    const column = columns.get(r) || make_column(r);
    column.box.style.left = `${r * width}px`;
    column.box.style.width = `${width}px`;
    column.box.classList.toggle('now', r === now.r);
    column.list.show(rows_of(column.round).length / 2);
  }
};
// Brings the event that is shown into sight.
export const show_strip = () => {
  const { r, i } = shown,
    width = column_width();
  if (r * width < strip.scrollLeft || (r + 1) * width > strip.scrollLeft + strip.clientWidth + 1) {
    strip.scrollLeft = Math.max(0, r * width - (strip.clientWidth > 2 * width - 2 ? width / 4 : 0));
  }
  draw_strip();
  const column = columns.get(r);
  if (!column || i < 0) return;
  const row = row_of(column.round, i);
  column.list.reveal(row);
  column.box.querySelector('.list').setAttribute('aria-activedescendant', `e${r}_${rows_of(column.round)[2 * row]}`);
};
export const clear_strip = () => {
  for (const column of columns.values()) column.box.remove();
  columns.clear();
  strip.scrollLeft = 0;
};
strip.addEventListener('scroll', draw_strip);
