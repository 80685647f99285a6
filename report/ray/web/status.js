// SPDX-License-Identifier: Apache-2.0
// The line that says where the page is, and the slider.
import { count, element } from './dom.js';
import { ray } from './nodes.js';
import { go_to, here, shown, total } from './position.js';

export const where = element('span', { className: 'where', role: 'status' });
export const slider = element('input', { type: 'range', min: 0, step: 1, 'aria-label': 'Event' });
slider.addEventListener('input', () => go_to(Number(slider.value)));

export const show_status = () => {
  const { r, i, round } = shown;
  const last_event = count(Math.max(0, round.events - 1));
  where.textContent = `round ${r} of 0–${ray().rounds.length - 1}, event ${i < 0 ? '–' : count(i)} of 0–${last_event}`;
  slider.max = total() - 1;
  slider.value = here();
  slider.setAttribute('aria-valuetext', where.textContent);
};
