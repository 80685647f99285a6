// SPDX-License-Identifier: Apache-2.0
// A list of which only the rows in sight are elements.
import { element } from './dom.js';

const kRow = 22,
  kMostPixels = 8e6;

export class List {
  // write(row, style): the row's HTML.
  constructor(box, write) {
    this.box = box;
    this.write = write;
    this.inside = element('div');
    box.append(this.inside);
    box.addEventListener('scroll', () => this.draw());
    this.rows = 0;
  }
  show(rows) {
    this.rows = rows;
    this.full = rows * kRow;
    this.height = Math.min(this.full, kMostPixels);
    this.inside.style.height = `${this.height}px`;
    this.draw();
  }
  // Pixels of all rows above the first in sight; a very long list is scrolled in proportion.
  top() {
    const sight = this.box.clientHeight;
    return this.full <= kMostPixels ? this.box.scrollTop : (this.box.scrollTop / Math.max(1, this.height - sight)) * (this.full - sight);
  }
  reveal(row) {
    const sight = this.box.clientHeight,
      top = this.top();
    if (row * kRow >= top && (row + 1) * kRow <= top + sight) return;
    const wanted = Math.max(0, Math.min(this.full - sight, row * kRow - sight / 2));
    this.box.scrollTop = this.full <= kMostPixels ? wanted : (wanted / Math.max(1, this.full - sight)) * (this.height - sight);
  }
  draw() {
    const top = this.top(),
      first = Math.max(0, Math.floor(top / kRow) - 4);
    const last = Math.min(this.rows, Math.ceil((top + this.box.clientHeight) / kRow) + 4);
    let html = '';
    for (let row = first; row < last; row += 1) html += this.write(row, `top:${Math.round(this.box.scrollTop + row * kRow - top)}px`);
    this.inside.innerHTML = html;
  }
}
