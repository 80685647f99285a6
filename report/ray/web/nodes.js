// SPDX-License-Identifier: Apache-2.0
// The ray that is looked at, the nodes of its warp, and Gaussians.
import { hex } from './dom.js';
import { bytes_of, numbers, page } from './page.js';

const NONE = 0xffffffff;
const warps = page.warps.map(({ nodes: columns, timeline }) => ({
  timeline,
  address: numbers(Float64Array, columns.address),
  kind: bytes_of(columns.kind),
  parent: numbers(Uint32Array, columns.parent),
  first: numbers(Uint32Array, columns.first),
  gaussian: numbers(Uint32Array, columns.gaussian),
  box: numbers(Float32Array, columns.box),
}));
const gaussian_numbers = numbers(Uint32Array, page.gaussians.number);
const gaussian_shapes = numbers(Float32Array, page.gaussians.shape);
const gaussian_place = new Map(Array.from(gaussian_numbers, (number, i) => [number, i]));

let chosen = 0;
export const ray_number = () => chosen;
export const choose = (number) => {
  chosen = number;
};
export const ray = () => page.rays[chosen];
export const nodes = () => warps[ray().warp];

export const in_blas = (node) => page.two_level && nodes().address[node] >= page.blas_base;
// A leaf of 64 B in layout quantised: kinds 5 and 7.
export const is_wide = (node) => nodes().kind[node] > 4;
export const node_name = (node) => {
  const kind = nodes().kind[node];
  const what = kind === 0 ? 'node' : (is_wide(node) ? 'wide ' : '') + (kind === 1 || kind === 5 ? 'instance' : 'leaf');
  return `${in_blas(node) ? 'BLAS ' : ''}${what} ${hex(nodes().address[node])}`;
};
export const gaussian_name = (hit) =>
  hit.gaussian !== 0
    ? `Gaussian ${hit.gaussian - 1}`
    : hit.owner !== 0
      ? `the Gaussian of ${node_name(hit.owner - 1)}`
      : 'a Gaussian that the trace does not name';
// Of a Gaussian: centre, three half axes, colour, opacity, kernel radius in standard deviations.
export const shape = (gaussian) => {
  const at = gaussian_place.get(gaussian);
  return at === undefined ? null : gaussian_shapes.subarray(17 * at, 17 * at + 17);
};
export const rgb = (s) => `rgb(${[s[12], s[13], s[14]].map((c) => Math.round(255 * c)).join(',')})`;
// The Gaussian of an entry of the stack: numbers + 1, 0 when it is not known.
export const gaussian_of = (entry) => {
  const owner = entry.instance !== 0 ? entry.instance - 1 : entry.node;
  const local = nodes().gaussian[owner];
  if (local === NONE || nodes().address[owner] < page.objects_base) return 0;
  return (entry.object !== 0 && ray().values ? nodes().gaussian[entry.object - 1] : 0) + local + 1;
};
