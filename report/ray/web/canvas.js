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
// Round numbers between two, at most so many.
export const ticks = (low, high, most) => {
  const rough = (high - low) / most,
    power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((f) => f * power).find((s) => s >= rough) || 10 * power;
  const list = [];
  for (let n = Math.ceil(low / step); n * step <= high && list.length < 100; n += 1) list.push(n * step);
  return list;
};
