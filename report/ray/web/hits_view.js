// SPDX-License-Identifier: Apache-2.0
// The hits along the ray: stems at t, as high as their share; rounds are bands; the dashed line is the light that is left.
import { colours, fit, ticks, write_beside } from './canvas.js';
import { element, time } from './dom.js';
import { hits } from './hits.js';
import { ray_number, rgb, shape } from './nodes.js';
import { go_to_event, shown } from './position.js';
import { round_of } from './rounds.js';

const kFoot = 22,
  kHead = 20;
const canvas_of_hits = element('canvas', { role: 'img', tabIndex: 0 }),
  hits_text = element('p', { className: 'note', role: 'status' });
export const hits_box = element(
  'section',
  { className: 'hits', 'aria-label': 'Hits by distance' },
  element('h2', { textContent: 'Its hits along the ray' }),
  canvas_of_hits,
  hits_text,
);
export const clear_hits_text = () => {
  hits_text.textContent = '';
};

const scale_of_hits = () => {
  const list = hits(),
    ends = list.map((hit) => hit.t);
  const low = Math.min(...ends),
    high = Math.max(...ends),
    margin = 0.03 * (high - low) || 0.05 * high || 1;
  return { low: low - margin, high: high + margin, most: Math.max(...list.map((hit) => hit.share), 1e-6) };
};
const draw_bands = (pen, style, x, height) => {
  const now = shown.r,
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
    pen.fillRect(left, 0, wide, height - kFoot);
    pen.globalAlpha = 1;
    pen.fillStyle = style.getPropertyValue(r === now ? '--ink' : '--muted');
    if (wide > 16 || r === now) pen.fillText(wide > 60 ? `round ${r}` : String(r), left + 3, 13);
  }
};
const draw_light = (pen, style, x, height) => {
  let light = 1;
  const y = () => height - kFoot - light * (height - kFoot - kHead);
  pen.setLineDash([4, 3]);
  pen.strokeStyle = style.getPropertyValue('--muted');
  pen.lineWidth = 1;
  pen.beginPath();
  pen.moveTo(0, y());
  for (const hit of hits()) {
    pen.lineTo(x(hit.t), y());
    light *= 1 - hit.alpha;
    pen.lineTo(x(hit.t), y());
  }
  pen.stroke();
  pen.setLineDash([]);
};
const draw_stems = (pen, style, x, y, height) => {
  const { event } = shown,
    just = event !== null && event.hit !== null ? event.hit.gaussian - 1 : -1;
  for (const hit of hits()) {
    const s = shape(hit.gaussian),
      top = y(hit.share),
      wide = hit.gaussian === just ? 7 : 4;
    pen.fillStyle = s === null ? style.getPropertyValue('--c8') : rgb(s);
    pen.strokeStyle = style.getPropertyValue(hit.gaussian === just ? '--accent' : '--ink');
    pen.lineWidth = hit.gaussian === just ? 2 : 0.7;
    pen.beginPath();
    pen.rect(x(hit.t) - wide / 2, top, wide, Math.max(2, height - kFoot - top));
    pen.fill();
    pen.stroke();
  }
};
const draw_scale = (pen, style, x, { width, height, low, high }) => {
  pen.fillStyle = style.getPropertyValue('--muted');
  pen.fillRect(0, height - kFoot, width, 1);
  for (const t of ticks(low, high, Math.max(2, width / 90))) {
    pen.fillRect(x(t), height - kFoot, 1, 4);
    pen.fillText(`t ${time(t)}`, Math.max(0, Math.min(width - 40, x(t) - 12)), height - 5);
  }
  const { i, round } = shown,
    t_max = i < 0 ? round.first_t_max : round.t_max[i];
  if (!Number.isFinite(t_max) || t_max < low || t_max > high) return;
  pen.fillStyle = style.getPropertyValue('--bad');
  pen.fillRect(x(t_max) - 1, 0, 2, height - kFoot);
  write_beside(pen, 't_max', x(t_max), 30, width);
};
export const draw_hits = () => {
  hits_box.hidden = hits().length === 0;
  if (hits_box.hidden || shown === null) return;
  const { pen, width, height } = fit(canvas_of_hits),
    style = colours(),
    { low, high, most } = scale_of_hits();
  const x = (t) => ((t - low) / (high - low)) * width,
    y = (share) => height - kFoot - (share / most) * (height - kFoot - kHead);
  draw_bands(pen, style, x, height);
  draw_light(pen, style, x, height);
  draw_stems(pen, style, x, y, height);
  draw_scale(pen, style, x, { width, height, low, high });
  const tallest = `gives ${Math.round(100 * most)} % of the pixel`,
    span = `${hits().length} hits between t = ${time(low)} and ${time(high)}`;
  canvas_of_hits.setAttribute('aria-label', `${span}; the tallest ${tallest}; now round ${shown.r}`);
  const help = 'Dashed: the light that is left. Point at a hit; click, or arrows, to go to it.';
  if (hits_text.textContent === '') hits_text.textContent = `The tallest ${tallest}. ${help}`;
};

const hit_text = (hit) =>
  `Gaussian ${hit.gaussian} at t = ${time(hit.t)}, round ${hit.r}: ` +
  `alpha ${time(hit.alpha)}, gives ${time(100 * hit.share)} % of the pixel.`;
const hit_at = (event) => {
  const { low, high } = scale_of_hits(),
    t = low + (event.offsetX / canvas_of_hits.clientWidth) * (high - low);
  return hits().reduce((best, hit) => (best === null || Math.abs(hit.t - t) < Math.abs(best.t - t) ? hit : best), null);
};
let hit_place = -1;
const choose_hit = (place) => {
  hit_place = place;
  const hit = hits()[place],
    round = round_of(ray_number(), hit.r);
  let found = -1;
  for (let i = 0; i < round.events; i += 1) if (round.gaussian[i] === hit.gaussian + 1 && round.noted[i] === 2) found = i;
  go_to_event(hit.r, found);
  hits_text.textContent = hit_text(hit);
};
canvas_of_hits.addEventListener('pointermove', (event) => {
  const hit = hit_at(event);
  if (hit !== null) hits_text.textContent = hit_text(hit);
});
canvas_of_hits.addEventListener('click', (event) => {
  const hit = hit_at(event);
  if (hit !== null) choose_hit(hits().indexOf(hit));
});
canvas_of_hits.addEventListener('keydown', (event) => {
  const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
  if (!step || hits().length === 0) return;
  choose_hit(Math.max(0, Math.min(hits().length - 1, hit_place + step)));
  event.preventDefault();
  event.stopPropagation();
});
