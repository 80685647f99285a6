// SPDX-License-Identifier: Apache-2.0
// The event that is shown, and the lists after it.
import { count, element, safe, time } from './dom.js';
import { panels } from './lists.js';
import { shown } from './position.js';
import { begin_text, copied, end_text, headline, read_text } from './words.js';

const event_box = element('section', { id: 'event', className: 'event', 'aria-live': 'polite', 'aria-label': 'Event' });
export const state_box = element('div', { className: 'state' }, event_box, ...panels);
// A page that plays is not read aloud.
export const announce = (aloud) => event_box.setAttribute('aria-live', aloud ? 'polite' : 'off');

const t_max_line = () => {
  const { round, i } = shown;
  if (!round.values) return '<p id="t_max"><b>t_max:</b> not in the trace</p>';
  const t_max = i < 0 ? round.first_t_max : round.t_max[i];
  const before = i < 1 ? round.first_t_max : round.t_max[i - 1];
  return `<p id="t_max" data-t="${t_max}"><b>t_max:</b> ${before !== t_max && i >= 0 ? `${time(before)} → ` : ''}${time(t_max)}</p>`;
};
export const show_event = () => {
  const { round, r, i, event } = shown;
  const lines = [];
  if (i < 0) {
    lines.push(`<p class="what">Round ${r} begins</p>`, ...begin_text(r).map((text) => `<p>${safe(text)}</p>`));
  } else {
    lines.push(`<p class="what">${safe(headline(event))}</p>`, `<p><b>Read:</b> ${safe(read_text(event))}</p>`);
    const texts = copied(event);
    if (texts.length > 0) lines.push(`<p><b>Copied:</b> ${safe(texts.join('; '))}</p>`);
  }
  lines.push(t_max_line());
  if (i === round.events - 1) lines.push(`<p>${safe(end_text(r))}</p>`);
  event_box.innerHTML = `<h2>Round ${r}, ${i < 0 ? 'its beginning' : `event ${count(i)}`}<span></span></h2>${lines.join('')}`;
};
