// SPDX-License-Identifier: Apache-2.0
// Time axis: the rounds of the warp, and what it did in them, in cycles.
import { colours, fit, ticks } from './canvas.js';
import { button, count, element, safe } from './dom.js';
import { nodes, ray } from './nodes.js';
import { go_to_event, here, place_of } from './position.js';

const canvas = element('canvas', { role: 'img' }),
  legend_box = element('p');
let near = false; // the shown round alone
const zoom = button('this round', 'Zoom to the shown round', () => {
  near = !near;
  zoom.setAttribute('aria-pressed', String(near));
  draw_axis();
});
zoom.setAttribute('aria-pressed', 'false');
export const axis = element('section', { className: 'axis', hidden: true, 'aria-label': 'Time axis' }, zoom, canvas, legend_box);

// What a warp does, in words: "memory" alone is the RT unit's wait for nodes elsewhere.
const kActivities = {
  raygen: 'ray generation shader',
  blend: 'shader blends',
  any_hit: 'any-hit shader',
  memory: 'shader waits for memory',
  trace: 'in the RT unit',
  fetch: 'shader fetches a node',
  drain: 'last stores are under way',
};
const ends = () => {
  const all = nodes().timeline,
    now = place_of(here()).r,
    own = near ? all.filter(([name, round]) => name === '' && round === now) : [];
  return (own.length > 0 ? own : all).reduce(([from, to], slice) => [Math.min(from, slice[2]), Math.max(to, slice[3])], [Infinity, -Infinity]);
};
const draw_slices = (pen, style, { x, from, to, names }) => {
  const now = place_of(here()).r,
    sums = new Map();
  for (const [name, round, begin, end] of nodes().timeline) {
    if (name === '') {
      pen.fillStyle = style.getPropertyValue(round === now ? '--accent' : '--shade');
      pen.fillRect(x(begin), 0, Math.max(1, x(end) - x(begin) - 1), 20);
      pen.fillStyle = style.getPropertyValue(round === now ? '--card' : '--ink');
      if (x(end) - x(begin) > 18 && round < ray().rounds.length) pen.fillText(String(round), x(begin) + 4, 14);
    } else {
      pen.fillStyle = style.getPropertyValue(`--c${(names.indexOf(name) % 12) + 1}`);
      pen.fillRect(x(begin), 24, Math.max(0.6, x(end) - x(begin)), 14);
      sums.set(name, (sums.get(name) || 0) + Math.max(0, Math.min(end, to) - Math.max(begin, from)));
    }
  }
  return sums;
};
export const draw_axis = () => {
  const slices = nodes().timeline;
  axis.hidden = slices.length === 0;
  if (axis.hidden) return;
  const { pen, width } = fit(canvas),
    style = colours();
  const [from, to] = ends(),
    x = (cycle) => ((cycle - from) / Math.max(1, to - from)) * width;
  const names = [...new Set(slices.filter(([name]) => name !== '').map(([name]) => name))];
  const sums = draw_slices(pen, style, { x, from, to, names });
  pen.fillStyle = style.getPropertyValue('--muted');
  for (const [i, cycle] of ticks(from, to, Math.max(2, width / 110)).entries()) {
    pen.fillRect(x(cycle), 38, 1, 6);
    if (x(cycle) < width - 60) pen.fillText(`${i === 0 ? 'cycle ' : ''}${count(cycle)}`, x(cycle) + 3, 54);
  }
  canvas.setAttribute('aria-label', `Rounds of the warp between cycle ${count(from)} and ${count(to)}`);
  const swatch = (i) => `<span class="swatch" style="background:var(--c${(i % 12) + 1})"></span>`;
  const legend = (name, i) => `<span>${swatch(i)}${safe(kActivities[name] ?? name.replaceAll('_', ' '))} ${count(sums.get(name))} cycles</span>`;
  legend_box.innerHTML = names.map(legend).join('');
};
canvas.addEventListener('click', (event) => {
  const [from, to] = ends(),
    cycle = from + (event.offsetX / canvas.clientWidth) * (to - from);
  const slice = nodes().timeline.find(([name, , begin, end]) => name === '' && begin <= cycle && cycle < end);
  if (slice && slice[1] < ray().rounds.length) go_to_event(slice[1], -1);
});
