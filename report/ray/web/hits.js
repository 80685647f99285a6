// SPDX-License-Identifier: Apache-2.0
// What the ray met: the hits that its rounds looked at, with the share of the pixel that each gives.
import { breather } from './dom.js';
import { ray, ray_number, shape } from './nodes.js';
import { page } from './page.js';
import { summary } from './position.js';
import { round_of, state_at } from './rounds.js';
import { cross, dot } from './vectors.js';

// Alpha of a Gaussian for the ray: its response where the ray passes nearest to the centre, in standard deviations.
const alpha_of = (gaussian) => {
  const s = shape(gaussian),
    { origin, direction } = ray();
  if (s === null) return 0;
  const [a, b, c] = [3, 6, 9].map((i) => s.subarray(i, i + 3));
  const size = dot(a, cross(b, c));
  const local = (v) => [dot(v, cross(b, c)) / size, dot(v, cross(c, a)) / size, dot(v, cross(a, b)) / size];
  const from = local(origin.map((v, i) => v - s[i])),
    along = local(direction);
  const t = -dot(from, along) / dot(along, along),
    near = from.map((v, i) => v + t * along[i]);
  const sigma2 = dot(near, near) * s[16] ** 2;
  return Math.min(0.99, s[15] * Math.exp(page.kernel_degree === 4 ? -(sigma2 ** 2) / 18 : -sigma2 / 2));
};

const lists = new Map(); // by ray
let run = 0;
export const hits = () => lists.get(ray_number()) || [];
// Calls done() when the hits of the ray are there, unless another ray has been chosen meanwhile.
export const find_hits = async (done) => {
  const own = ray_number(),
    mine = ++run,
    list = [],
    all = ray().rounds.length,
    breathe = breather();
  let light = 1;
  for (let r = 0; r < all && ray().values && !lists.has(own); r += 1) {
    const round = round_of(own, r),
      kept = state_at(round, round.events - 1).k;
    if (!page.sorted) kept.sort((a, b) => a.t - b.t);
    for (const hit of kept.slice(0, summary(r).processed)) {
      const alpha = alpha_of(hit.gaussian - 1);
      list.push({ r, t: hit.t, gaussian: hit.gaussian - 1, alpha, share: light * alpha });
      light *= 1 - alpha;
    }
    await breathe();
    if (mine !== run) return;
  }
  if (!lists.has(own)) lists.set(own, list);
  done();
};
