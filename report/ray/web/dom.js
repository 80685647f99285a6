// SPDX-License-Identifier: Apache-2.0
// Elements, and numbers as text.

export const element = (tag, attributes = {}, ...children) => {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name in made && name !== 'list') made[name] = value;
    else made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
};
export const button = (text, title, action) =>
  element('button', { type: 'button', textContent: text, title, 'aria-label': title, onclick: action });

export const safe = (text) => String(text).replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`);
export const count = (n) => n.toLocaleString('en');
// "1 hit", "2,000 hits".
export const counted = (n, what) => `${count(n)} ${what}${n === 1 ? '' : 's'}`;
export const time = (t) => (t === undefined || Number.isNaN(t) ? '?' : t === Infinity ? '∞' : String(Number(t.toPrecision(5))));
export const hex = (n) => `0x${n.toString(16)}`;

// How many of the ascending stamps are at most i.
export const until = (stamps, i) => {
  let low = 0,
    high = stamps.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (stamps[middle] <= i) low = middle + 1;
    else high = middle;
  }
  return low;
};
// Long work, in steps: the page stays alive. Each call ends its turn when 30 ms are over.
export const breather = () => {
  let began = performance.now();
  return async () => {
    if (performance.now() - began <= 30) return;
    await new Promise((resolve) => {
      setTimeout(resolve);
    });
    began = performance.now();
  };
};
