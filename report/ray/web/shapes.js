// SPDX-License-Identifier: Apache-2.0
// Boxes and Gaussians as they are drawn.
import { limit } from './camera.js';
import { gaussian_of, in_blas, nodes, rgb, shape } from './nodes.js';

const in_gaussian = (s, p) => [0, 1, 2].map((i) => s[i] + s[3 + i] * p[0] + s[6 + i] * p[1] + s[9 + i] * p[2]);

// entry: through which the node was reached.
export const draw_box = ({ place, line }, node, colour, thick, entry) => {
  const b = nodes().box.subarray(6 * node, 6 * node + 6);
  if (b.length === 0 || Number.isNaN(b[0])) return;
  const inside_blas = in_blas(node),
    s = inside_blas ? shape(gaussian_of(entry) - 1) : null;
  if (inside_blas && s === null) return;
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => {
    const p = [b[i & 1 ? 3 : 0], b[i & 2 ? 4 : 1], b[i & 4 ? 5 : 2]];
    return place(inside_blas ? in_gaussian(s, p) : p);
  });
  for (let i = 0; i < 8; i += 1) for (const bit of [1, 2, 4]) if ((i & bit) === 0) line(corners[i], corners[i | bit], colour, thick);
};

// The outline of an ellipsoid under a parallel projection is an ellipse: rows of the projection times its half axes.
const outline = (place, s) => {
  const zero = place(in_gaussian(s, [0, 0, 0]));
  const unit = (axis) => [0, 1, 2].map((i) => (i === axis ? 1 : 0));
  const axes = [0, 1, 2].map((axis) => place(in_gaussian(s, unit(axis))).map((v, i) => v - zero[i]));
  const sum = (of) => axes.reduce((all, a) => all + of(a), 0);
  const xx = sum((a) => a[0] * a[0]),
    xy = sum((a) => a[0] * a[1]),
    yy = sum((a) => a[1] * a[1]);
  const middle = (xx + yy) / 2,
    spread = Math.hypot((xx - yy) / 2, xy);
  const radii = [middle + spread, middle - spread].map((v) => Math.min(1e5, Math.sqrt(Math.max(0, v))));
  return { zero, radii, angle: Math.atan2(2 * xy, xx - yy) / 2, height: Math.sqrt(yy) };
};
export const draw_ellipsoid = ({ pen, style, place, labels }, gaussian, colour, filled, label) => {
  const s = shape(gaussian);
  if (s === null) return;
  const { zero, radii, angle, height } = outline(place, s);
  pen.beginPath();
  pen.ellipse(limit(zero[0]), limit(zero[1]), ...radii, angle, 0, 2 * Math.PI);
  if (filled) {
    pen.globalAlpha = Math.max(0.15, 0.45 * s[15]);
    pen.fillStyle = rgb(s);
    pen.fill();
    pen.globalAlpha = 1;
  }
  pen.strokeStyle = style.getPropertyValue(colour);
  pen.lineWidth = filled ? 1.6 : 1;
  pen.stroke();
  if (!label) return;
  labels.unshift({ words: String(gaussian), x: limit(zero[0]) + 3, y: limit(zero[1] - height) - 3, colour: style.getPropertyValue('--ink') });
};
