// SPDX-License-Identifier: Apache-2.0
// What the page holds for its script: a description as JSON, and bytes in elements of their own (ray_page.cpp).

export const page = JSON.parse(document.getElementById('page').textContent);
export const several = page.ahead > 1; // nodes of a ray under way at once: events come in another order than depth first

export const bytes_of = (text) => {
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i += 1) bytes[i] = raw.charCodeAt(i);
  return bytes;
};
export const numbers = (Type, text) => new Type(bytes_of(text).buffer);

// Reads what packed_round.h writes.
export class Bytes {
  constructor(bytes) {
    this.bytes = bytes;
    this.view = new DataView(bytes.buffer);
    this.at = 0;
  }
  u8() {
    return this.bytes[this.at++];
  }
  number() {
    let value = 0,
      factor = 1;
    for (;;) {
      const byte = this.bytes[this.at++];
      value += (byte & 127) * factor;
      if (byte < 128) return value;
      factor *= 128;
    }
  }
  time(there) {
    if (!there) return NaN;
    this.at += 4;
    return this.view.getFloat32(this.at - 4, true);
  }
}
