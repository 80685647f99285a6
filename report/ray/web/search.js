// SPDX-License-Identifier: Apache-2.0
// Finding a node or a Gaussian: the events that are about it, one after the other.
import { breather, count, element } from './dom.js';
import { nodes, ray, ray_number } from './nodes.js';
import { go_to, here, position_of } from './position.js';
import { round_of } from './rounds.js';
import { where } from './status.js';

export const search = element('input', {
  type: 'search',
  placeholder: '0x address or Gaussian',
  'aria-label': 'Find a node by its address or a Gaussian by its number',
});

// Whether an event is the one that is looked for; null: no event can be.
const matcher = (text) => {
  if (!/^0x/i.test(text)) return (round, i) => round.gaussian[i] === Number(text) + 1;
  const node = nodes().address.indexOf(Number(text));
  return node < 0 ? null : (round, i) => round.node[i] === node;
};
let run_of_search = 0;
const find = async () => {
  const text = search.value.trim().replace(/^#/, '');
  const mine = ++run_of_search;
  if (text === '') return;
  const matches = matcher(text),
    breathe = breather();
  let found = 0,
    first = -1,
    next = -1;
  for (let r = 0; r < ray().rounds.length && matches !== null; r += 1) {
    const round = round_of(ray_number(), r);
    for (let i = 0; i < round.events; i += 1) {
      if (!matches(round, i)) continue;
      found += 1;
      const at = position_of(r, i);
      if (first < 0) first = at;
      if (next < 0 && at > here()) next = at;
    }
    await breathe();
    if (mine !== run_of_search) return;
  }
  if (found > 0) go_to(next >= 0 ? next : first);
  where.textContent =
    found === 0
      ? `${text}: this ray has no event about it`
      : `${where.textContent}; ${count(found)} event${found === 1 ? '' : 's'} about ${text}`;
};
search.addEventListener('keydown', (event) => {
  if (event.key === 'Enter') find();
  else if (event.key === 'Escape') search.blur();
});
