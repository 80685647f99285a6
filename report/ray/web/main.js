// SPDX-License-Identifier: Apache-2.0
// The page of grtx ray: what it consists of, what is drawn when it goes somewhere, and its keys.
import { axis, draw_axis } from './axis.js';
import { reset_camera } from './camera.js';
import { element } from './dom.js';
import { find_hits } from './hits.js';
import { clear_hits_text, draw_hits, hits_box } from './hits_view.js';
import { choose } from './nodes.js';
import { follow, go_to, go_to_round, here, measure_ray, summary, total } from './position.js';
import { show_event, state_box } from './state.js';
import { show_lists } from './lists.js';
import { all_taken_up, forget_rounds } from './rounds.js';
import { fold } from './rows.js';
import { search } from './search.js';
import { show_status, slider } from './status.js';
import { pixel_box, show_pixel, story, tell_story } from './story.js';
import { clear_strip, show_strip, strip } from './strip.js';
import { bar_of_tools, keys, next_hit, ray_choice, stop, toggle_play } from './tools.js';
import { draw_view, view_box } from './view.js';

document
  .getElementById('player')
  .append(
    element('div', { className: 'first-look' }, pixel_box, element('div', {}, story, hits_box)),
    bar_of_tools,
    keys,
    axis,
    element('div', { className: 'stage' }, strip, state_box),
    view_box,
  );
for (const show of [show_strip, show_event, show_lists, show_status, draw_axis, draw_hits, draw_view]) follow(show);

const kActions = {
  ArrowRight: () => go_to(here() + 1),
  ArrowLeft: () => go_to(here() - 1),
  Home: () => go_to(0),
  End: () => go_to(total() - 1),
  n: () => next_hit(1),
  p: () => next_hit(-1),
  '[': () => go_to_round(-1),
  ']': () => go_to_round(1),
  ' ': toggle_play,
  '/': () => search.focus(),
};
document.addEventListener('keydown', (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const tag = event.target.tagName;
  if (tag === 'SELECT' || tag === 'SUMMARY' || (tag === 'INPUT' && event.target !== slider)) return;
  if (tag === 'BUTTON' && (event.key === ' ' || event.key === 'Enter')) return;
  if (!kActions[event.key]) return;
  event.preventDefault();
  kActions[event.key]();
});
fold.addEventListener('change', () => {
  for (const round of all_taken_up()) {
    round.rows = null;
    round.open.clear();
  }
  go_to(here());
});
addEventListener('resize', () => go_to(here()));
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
  draw_axis();
  draw_hits();
  draw_view();
});

const choose_ray = (number) => {
  stop();
  choose(number);
  clear_strip();
  measure_ray();
  reset_camera();
  clear_hits_text();
  go_to(summary(0).events); // the end of the first round: its lists are full, its hits are met
  tell_story();
  show_pixel();
  find_hits(() => {
    tell_story();
    draw_hits();
  });
};
ray_choice.addEventListener('change', () => {
  forget_rounds();
  choose_ray(Number(ray_choice.value));
});
choose_ray(0);
document.documentElement.dataset.ready = '1';
