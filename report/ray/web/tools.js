// SPDX-License-Identifier: Apache-2.0
// The bar of tools: going from event to event, playing, folding, finding.
import { button, element } from './dom.js';
import { page } from './page.js';
import { go_to, go_to_hit, here, total } from './position.js';
import { fold } from './rows.js';
import { search } from './search.js';
import { announce } from './state.js';
import { slider, where } from './status.js';

export const ray_choice = element(
  'select',
  { 'aria-label': 'Ray' },
  ...page.rays.map((r, i) => element('option', { value: i, textContent: r.name })),
);
const speed = element(
  'select',
  { 'aria-label': 'Events a second' },
  ...[1, 4, 16, 64, 256].map((n) => element('option', { value: n, textContent: `${n}/s`, selected: n === 4 })),
);

let playing = null;
const show_playing = () => {
  announce(playing === null);
  play_button.textContent = playing === null ? 'play' : 'pause';
  play_button.title = playing === null ? 'Play (space)' : 'Pause (space)';
  play_button.setAttribute('aria-label', play_button.title);
};
export const stop = () => {
  clearInterval(playing);
  playing = null;
  show_playing();
};
export const toggle_play = () => {
  if (playing !== null) return stop();
  if (here() >= total() - 1) go_to(0);
  const rate = Number(speed.value),
    frames = Math.min(rate, 32);
  playing = setInterval(() => {
    go_to(here() + rate / frames);
    if (here() >= total() - 1) stop();
  }, 1000 / frames);
  return show_playing();
};
const play_button = button('play', 'Play (space)', toggle_play);
speed.addEventListener('change', () => {
  if (playing === null) return;
  stop();
  toggle_play();
});

export const next_hit = (step) => {
  if (!go_to_hit(step)) where.textContent = step > 0 ? 'no hit behind this event' : 'no hit before this event';
};
export const bar_of_tools = element(
  'div',
  { className: 'bar-of-tools', role: 'group', 'aria-label': 'Player' },
  ...(page.rays.length > 1 ? [ray_choice] : []),
  button('|◀', 'First event (Home)', () => go_to(0)),
  button('‹', 'One event back (left arrow)', () => go_to(here() - 1)),
  play_button,
  button('›', 'One event on (right arrow)', () => go_to(here() + 1)),
  button('▶|', 'Last event (End)', () => go_to(total() - 1)),
  button('‹ hit', 'Last event that called the any-hit shader (p)', () => next_hit(-1)),
  button('hit ›', 'Next event that called the any-hit shader (n)', () => next_hit(1)),
  speed,
  element('label', {}, 'fold', fold),
  search,
  where,
  slider,
);

export const keys = element('details', { className: 'keys' });
const kLegend = [
  ['internal', 'node'],
  ['instance', 'instance leaf'],
  ['miss', 'leaf missed'],
  ['behind', 'hit, seen before'],
  ['inserted', 'hit, into the k-buffer'],
  ['displaced', 'hit, another fell out'],
  ['rejected', 'hit, rejected'],
  ['beyond', 'beyond t_max'],
  ['take', 'checkpoint taken'],
];
const legend_row = ([look, text]) =>
  `<span class="row k-${look}" style="position:static;display:inline-block"><span class="dot"></span>${text}</span>`;
keys.innerHTML =
  '<summary>Keys, colours</summary><p><kbd>←</kbd> <kbd>→</kbd> an event · <kbd>n</kbd> <kbd>p</kbd> next, last hit · ' +
  '<kbd>[</kbd> <kbd>]</kbd> a round · <kbd>Home</kbd> <kbd>End</kbd> · <kbd>space</kbd> play · <kbd>/</kbd> find, ' +
  '<kbd>Enter</kbd> the next one · in a list <kbd>↑</kbd> <kbd>↓</kbd> a row, <kbd>Enter</kbd> fold. ' +
  `In the view: arrows turn, <kbd>+</kbd> <kbd>-</kbd> zoom.</p><p>${kLegend.map(legend_row).join('')}</p>`;
