// SPDX-License-Identifier: Apache-2.0
// Where the page is: a ray's rounds one after the other, each from -1 (it begins) to its last event.
import { until } from './dom.js';
import { ray, ray_number } from './nodes.js';
import { round_of, state_at } from './rounds.js';

let position = 0,
  offsets = [0];
export let shown = null; // the round r, its event i, and the state after it
const followers = [];

// To be called whenever the page goes somewhere.
export const follow = (show) => followers.push(show);
export const summary = (r) => ray().rounds[r];
export const here = () => position;
export const total = () => offsets[offsets.length - 1];
export const place_of = (at) => {
  const r = Math.min(until(offsets, at) - 1, ray().rounds.length - 1);
  return { r, i: at - offsets[r] - 1 };
};
export const position_of = (r, i) => offsets[r] + 1 + i;

export const go_to = (at) => {
  position = Math.max(0, Math.min(total() - 1, at));
  const { r, i } = place_of(position),
    round = round_of(ray_number(), r);
  shown = { ...state_at(round, i), round, r, i };
  for (const show of followers) show();
};
export const go_to_event = (r, i) => go_to(position_of(r, i));
// Returns whether there is another event with a hit.
export const go_to_hit = (step) => {
  let { r, i } = place_of(position);
  for (; r >= 0 && r < ray().rounds.length; r += step) {
    const round = round_of(ray_number(), r);
    for (i += step; i >= 0 && i < round.events; i += step) {
      if (round.noted[i] !== 2) continue;
      go_to_event(r, i);
      return true;
    }
    i = step > 0 ? -1 : r > 0 ? summary(r - 1).events : 0;
  }
  return false;
};
export const go_to_round = (step) => {
  const { r, i } = place_of(position);
  const next = step < 0 && i >= 0 ? r : r + step;
  go_to_event(Math.max(0, Math.min(ray().rounds.length - 1, next)), -1);
};
// Another ray has been chosen.
export const measure_ray = () => {
  offsets = [0];
  for (const round of ray().rounds) offsets.push(total() + round.events + 1);
};
