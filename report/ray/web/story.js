// SPDX-License-Identifier: Apache-2.0
// A paragraph: what the ray did. And its pixel in the picture of the view.
import { count, counted, element, time } from './dom.js';
import { hits } from './hits.js';
import { ray } from './nodes.js';
import { page } from './page.js';

export const story = element('p', { className: 'story' });
export const pixel_box = element('figure', { className: 'pixel' });

const rounds_words = (all, read) => {
  if (all.length < 2) return [];
  const again = all.filter((s) => s.replay).length;
  const which = again === all.length - 1 ? 'All rounds but the first' : `${count(again)} rounds`;
  const began = again > 0 ? `${which} went on from checkpoints` : 'Each round began at the root again';
  return [`${began}; the first read ${Math.round((100 * all[0].read) / Math.max(1, read))} % of the nodes.`];
};
const end_words = (last) => {
  if (last && last.terminated) return ['It ended because it was opaque.'];
  return last && ray().values ? [`It left the scene with ${Number((100 * last.transmittance).toPrecision(3))} % of its light.`] : [];
};
const most_words = () => {
  const most = hits().reduce((best, hit) => (best === null || hit.share > best.share ? hit : best), null);
  if (most === null || !(most.share > 0)) return [];
  const place = `Gaussian ${most.gaussian} at t = ${time(most.t)}, met in round ${most.r}`;
  return [`Most of the pixel, ${Math.round(100 * most.share)} %, is ${place}.`];
};
export const tell_story = () => {
  const { name, rounds: all } = ray();
  const sum = (what) => all.reduce((total_of, s) => total_of + s[what], 0);
  const read = sum('read');
  const slow = page.median > 0 ? ` (${(read / page.median).toFixed(1)} times the frame's median)` : '';
  const took = `took ${counted(all.length, 'round')}, read ${counted(read, 'node')}${slow}`;
  const blended = sum('blended');
  const met = `looked at ${counted(sum('processed'), 'hit')}, of which ${count(blended)} ${blended === 1 ? 'was' : 'were'} blended`;
  const words = [`The ray of ${name} ${took} and ${met}.`];
  story.textContent = [...words, ...rounds_words(all, read), ...end_words(all[all.length - 1]), ...most_words()].join(' ');
};

export const show_pixel = () => {
  const [width, height] = page.size,
    [px, py] = ray().pixel;
  const mark = element('span', { className: 'mark' });
  mark.style.left = `${((px + 0.5) / width) * 100}%`;
  mark.style.top = `${((py + 0.5) / height) * 100}%`;
  const picture = page.picture ? [element('img', { src: page.picture, alt: 'The picture of the view' })] : [];
  const ground = element('div', { className: 'ground' }, ...picture, mark);
  if (!page.picture) ground.style.aspectRatio = `${width} / ${height}`;
  const textContent = `pixel ${px},${py} of ${width} × ${height}${page.picture ? '' : '; --image shows the picture'}`;
  pixel_box.replaceChildren(ground, element('figcaption', { textContent }));
};
