// SPDX-License-Identifier: Apache-2.0
// Drawing on a canvas.

export const colours = () => getComputedStyle(document.documentElement);
// The canvas cleared, in as many pixels as the screen has there.
export const fit = (canvas) => {
  const scale = devicePixelRatio || 1,
    width = canvas.clientWidth,
    height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * scale) || canvas.height !== Math.round(height * scale)) {
    canvas.width = Math.round(width * scale);
    canvas.height = Math.round(height * scale);
  }
  const pen = canvas.getContext('2d');
  pen.setTransform(scale, 0, 0, scale, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = `12px ${getComputedStyle(document.body).fontFamily}`;
  return { pen, width, height };
};
// Words beside a place, to its right where they fit.
export const write_beside = (pen, words, x, y, width) =>
  pen.fillText(words, x + 4 + pen.measureText(words).width > width ? Math.max(0, x - 4 - pen.measureText(words).width) : x + 4, y);
// Labels, the first ones first; those that would stand on another are left out.
export const write_apart = (pen, labels) => {
  const kHeight = 12,
    taken = [];
  for (const { words, x, y, colour } of labels) {
    const right = x + pen.measureText(words).width;
    if (taken.some((other) => x < other.right + 3 && other.x < right + 3 && Math.abs(y - other.y) < kHeight)) continue;
    taken.push({ x, right, y });
    pen.fillStyle = colour;
    pen.fillText(words, x, y);
  }
};
// Round numbers between two, at most so many.
export const ticks = (low, high, most) => {
  const rough = (high - low) / most,
    power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((f) => f * power).find((s) => s >= rough) || 10 * power;
  const list = [];
  for (let n = Math.ceil(low / step); n * step <= high && list.length < 100; n += 1) list.push(n * step);
  return list;
};
