// SPDX-License-Identifier: Apache-2.0
// How boxes and Gaussians are seen: from the side of the ray, which runs from left to right.
import { colours, fit } from './canvas.js';
import { ray, ray_number } from './nodes.js';
import { round_of, state_at } from './rounds.js';
import { cross, dot } from './vectors.js';

const kSteps = {
  ArrowLeft: { turn: -0.1 },
  ArrowRight: { turn: 0.1 },
  ArrowUp: { tilt: -0.1 },
  ArrowDown: { tilt: 0.1 },
  '+': { zoom: 1.25 },
  '=': { zoom: 1.25 },
  '-': { zoom: 1 / 1.25 },
};
const kRest = { turn: 0, tilt: 0.25, zoom: 1 };
let seen = { ...kRest, centre: 0, reach: 1 };

export const view_now = () => seen;
export const move_camera = ({ turn = 0, tilt = 0, zoom = 1 }) => {
  seen = { ...seen, turn: seen.turn + turn, tilt: seen.tilt + tilt, zoom: seen.zoom * zoom };
};
export const step_of_key = (key) => kSteps[key];
// Ends where most of the hits that a round kept lie.
export const reset_camera = () => {
  seen = { ...seen, ...kRest };
  if (!ray().values) return;
  const times = [];
  const rounds_looked_at = Math.min(ray().rounds.length, 8);
  for (let r = 0; r < rounds_looked_at; r += 1) {
    const round = round_of(ray_number(), r);
    for (const hit of [...round.evictions, ...state_at(round, round.events - 1).k]) if (Number.isFinite(hit.t)) times.push(hit.t);
  }
  times.sort((a, b) => a - b);
  const nearest = times.length > 0 ? times[0] : 0;
  const last = times.length > 0 ? times[Math.floor((times.length > 10 ? 0.9 : 1) * (times.length - 1))] : 1;
  const margin = Math.max(0.12 * (last - nearest), 1e-3 * last);
  seen.centre = (nearest + last) / 2;
  seen.reach = (last - nearest) / 2 + 2 * margin;
};

// Along the ray, and two axes across it.
const basis = () => {
  const { direction } = ray(),
    length = Math.hypot(...direction) || 1;
  const x = direction.map((c) => c / length),
    across = cross(x, Math.abs(x[1]) < 0.9 ? [0, 1, 0] : [1, 0, 0]),
    size = Math.hypot(...across);
  const z = across.map((c) => c / size);
  return [x, cross(z, x), z];
};
// Of a point from a place, in the direction of an axis.
const along = (point, from, axis) => dot(
  point.map((c, i) => c - from[i]),
  axis,
);

export const limit = (v) => Math.max(-1e5, Math.min(1e5, v));
// The projection, and the pen on it.
export const view_tools = (canvas) => {
  const { pen, width, height } = fit(canvas),
    style = colours(),
    [x, y, z] = basis(),
    { origin, direction } = ray(),
    { turn, tilt, zoom, centre, reach } = seen;
  const scale = (zoom * width) / (2 * reach);
  const place = (p) => {
    const [a, b, c] = [along(p, origin, x) - centre, along(p, origin, y), along(p, origin, z)];
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
  return { pen, style, width, place, on_ray, line, labels: [] };
};
