// SPDX-License-Identifier: Apache-2.0
// View of the boxes and Gaussians that the ray met.
import { limit, move_camera, reset_camera, step_of_key, view_now, view_tools } from './camera.js';
import { ticks, write_apart } from './canvas.js';
import { button, element, time, until } from './dom.js';
import { in_blas, nodes, ray } from './nodes.js';
import { page } from './page.js';
import { shown } from './position.js';
import { looks } from './events.js';
import { draw_box, draw_ellipsoid } from './shapes.js';

const kMostBoxes = 2000,
  kMostEvictions = 200,
  kMostHits = 256;
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
const kHelp = 'Left to right: along the ray. Filled: in the k-buffer; red: evicted; blue: just hit. Drag or arrows turn, + and - zoom.';
const reset = button('reset', 'Reset the view', () => {
  reset_camera();
  draw_view();
});
export const view_box = element('section', {
  className: 'view3d',
  hidden: !page.rays.some((r) => r.values),
  'aria-label': 'Boxes and Gaussians',
});
if (!view_box.hidden) {
  const controls = [element('label', {}, 'boxes ', what_boxes), reset, element('span', { className: 'note', textContent: kHelp })];
  view_box.append(element('h2', {}, 'Boxes and Gaussians'), view_canvas, element('div', { className: 'controls' }, ...controls));
}

const draw_boxes = (tools) => {
  const { event, round, i } = shown,
    which = what_boxes.value;
  for (let e = Math.max(0, i - kMostBoxes); which === 'round' && e <= i; e += 1) {
    const { name } = looks[round.look[e]];
    if ((name === 'internal' || name === 'instance') && !in_blas(round.node[e])) draw_box(tools, round.node[e], '--line', 1, null);
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
const draw_gaussians = (tools) => {
  const { event, round, i, k } = shown,
    { pen, style, on_ray } = tools;
  const evicted = until(round.evicted_at, i);
  for (let e = Math.max(0, evicted - kMostEvictions); e < evicted; e += 1) {
    draw_ellipsoid(tools, round.evictions[e].gaussian - 1, '--c4', false, evicted <= 12);
  }
  for (const hit of k.slice(0, kMostHits)) draw_ellipsoid(tools, hit.gaussian - 1, '--c3', true, k.length <= 16);
  if (event !== null && event.hit !== null) draw_ellipsoid(tools, event.hit.gaussian - 1, '--accent', false, true);
  for (const hit of k.slice(0, kMostHits)) {
    const [px, py] = on_ray(hit.t);
    pen.fillStyle = style.getPropertyValue('--ink');
    pen.fillRect(limit(px) - 1, limit(py) - 4, 2, 8);
  }
};
const draw_ray = ({ pen, style, width, on_ray, line, labels }) => {
  const { centre, reach, zoom } = view_now();
  for (const t of ticks(Math.max(0, centre - reach / zoom), centre + reach / zoom, 8)) {
    const [px, py] = on_ray(t);
    line([px, py - 4], [px, py + 4], '--muted', 1);
    labels.unshift({ words: `t ${time(t)}`, x: Math.max(0, limit(px) - 12), y: limit(py) + 18, colour: style.getPropertyValue('--ink') });
  }
  const { round, i } = shown,
    t_max = i < 0 ? round.first_t_max : round.t_max[i];
  if (!Number.isFinite(t_max)) return;
  const [px, py] = on_ray(t_max);
  line([px, py - 26], [px, py + 26], '--bad', 2);
  const words = `t_max ${time(t_max)}`,
    over = px > 0 && px < width && px + 4 + pen.measureText(words).width > width;
  const x = over ? px - 4 - pen.measureText(words).width : px + 4;
  labels.unshift({ words, x: limit(x), y: limit(py) + 34, colour: style.getPropertyValue('--bad') });
};
export const draw_view = () => {
  if (view_box.hidden || shown === null || !ray().values) return;
  const tools_of_view = view_tools(view_canvas),
    { on_ray, line } = tools_of_view,
    { centre, reach, zoom } = view_now();
  line(on_ray(0), on_ray(centre + (3 * reach) / Math.min(zoom, 1)), '--ink', 1);
  draw_boxes(tools_of_view);
  draw_gaussians(tools_of_view);
  draw_ray(tools_of_view);
  write_apart(tools_of_view.pen, tools_of_view.labels); // t_max, the axis, the hit of the event, hits, evictions
};

what_boxes.onchange = draw_view;
let drag = null;
view_canvas.addEventListener('pointerdown', (event) => {
  drag = [event.clientX, event.clientY];
  view_canvas.setPointerCapture(event.pointerId);
});
view_canvas.addEventListener('pointermove', (event) => {
  if (drag === null) return;
  move_camera({ turn: (event.clientX - drag[0]) * 0.01, tilt: (event.clientY - drag[1]) * 0.01 });
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
    move_camera({ zoom: Math.exp(-event.deltaY * 0.001) });
    draw_view();
  },
  { passive: false },
);
view_canvas.addEventListener('keydown', (event) => {
  const step = step_of_key(event.key);
  if (!step) return;
  move_camera(step);
  event.preventDefault();
  event.stopPropagation();
  draw_view();
});
