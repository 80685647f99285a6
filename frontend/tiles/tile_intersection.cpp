// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/tiles/tile_intersection.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "grtx/frontend/gaussian/gaussian_math.h"
#include "grtx/frontend/tiles/tile_intersection_avx2.h"
#include "grtx/frontend/tiles/tile_margins.h"

namespace grtx::frontend {
namespace {

constexpr float kNoBound = std::numeric_limits<float>::infinity();

/// Coefficients of q(u, v) = one + u u + v v + uu u^2 + uv u v + vv v^2; rays with q <= slack may pass within the
/// radius.
struct Outline {
  float one, u, v, uu, uv, vv;
  float slack;
};

Outline outline_portable(const TileGaussian& g, const TileRays& tile) {
  const float mean[3] = {g.mean.x - tile.origin.x, g.mean.y - tile.origin.y, g.mean.z - tile.origin.z};
  float a[3], l[3][3], w[3][3];  // l and w: by column
  for (int i = 0; i < 3; ++i) {
    const glm::vec3& row = g.to_unit[i];
    a[i] = (row.x * mean[0] + row.y * mean[1]) + row.z * mean[2];
    for (int c = 0; c < 3; ++c) {
      l[c][i] = (row.x * tile.frame[0][c] + row.y * tile.frame[1][c]) + row.z * tile.frame[2][c];
    }
  }
  float ww[3], ll[3], product[3];
  for (int c = 0; c < 3; ++c) {
    w[c][0] = a[1] * l[c][2] - a[2] * l[c][1];
    w[c][1] = a[2] * l[c][0] - a[0] * l[c][2];
    w[c][2] = a[0] * l[c][1] - a[1] * l[c][0];
    ww[c] = detail::dot3(w[c], w[c]);
    ll[c] = detail::dot3(l[c], l[c]);
  }
  for (int c = 0; c < 3; ++c) {
    const int d = (c + 1) % 3;
    product[c] = detail::dot3(w[c], w[d]) - detail::dot3(l[c], l[d]);
  }
  Outline o;
  o.one = ww[0] - ll[0];
  o.uu = ww[1] - ll[1];
  o.vv = ww[2] - ll[2];
  o.u = 2.0f * product[0];
  o.uv = 2.0f * product[1];
  o.v = 2.0f * product[2];
  o.slack = outline_slack(tile, g.norm, mean, a, ww, ll);
  return o;
}

void test_outlines_portable(const TileStructure& structure, const TileRays& tile, TileCandidate* candidates,
                            std::size_t count) {
  for (TileCandidate* c = candidates; c != candidates + count; ++c) {
    auto wanted = static_cast<unsigned>(c->rays);
    c->rays = 0;
    if (!tile.narrow) {
      for (; wanted != 0; wanted &= wanted - 1) c->rays |= std::uint64_t{0xFF} << (std::countr_zero(wanted) * 8);
      continue;
    }
    const Outline o = outline_portable(structure.gaussian(c->gaussian), tile);
    for (; wanted != 0; wanted &= wanted - 1) {
      const auto vector = static_cast<unsigned>(std::countr_zero(wanted));
      for (unsigned r = vector * kTileLanes; r < (vector + 1) * kTileLanes; ++r) {
        const float u = tile.u[r], v = tile.v[r];
        const float q = (u * (o.uu * u + o.u) + o.one) + v * ((o.vv * v + o.v) + o.uv * u);
        c->rays |= std::uint64_t{!(q > o.slack)} << r;
      }
    }
  }
}

/// Mask of the vectors that contain columns first..last and rows top..bottom, all in 0..7.
std::uint32_t vectors_of(int first, int last, int top, int bottom) {
  const unsigned columns = last < 4 ? 0x55u : first >= 4 ? 0xAAu : 0xFFu;
  return columns & (0xFFu << (top / 2 * 2)) & (0xFFu >> (6 - bottom / 2 * 2));
}

/// Columns (or rows) of the grid that a box may cover. The box's coordinate times depth is in [low, high], its depth
/// between near and far.
struct Covered {
  int first, last;
  Covered(float low, float high, float inverse_near, float inverse_far, float scale, float margin) {
    float a = std::min(low * inverse_near, low * inverse_far) * scale + 0.5f * (kTileEdge - 1);
    float b = std::max(high * inverse_near, high * inverse_far) * scale + 0.5f * (kTileEdge - 1);
    const float slack = margin + (b - a) * kGridSlack;
    a -= slack;
    b += slack;
    first = static_cast<int>(std::ceil(std::min(std::max(a, 0.0f), 8.0f)));
    last = static_cast<int>(std::floor(std::max(std::min(b, 7.0f), -1.0f)));
  }
};

unsigned test_node_portable(const TileNode& node, const TileRays& tile, const TileDepths& depths, std::uint32_t bucket,
                            TileNodeHits& hits) {
  unsigned mask = 0;
  for (unsigned slot = 0; slot < kTileNodeWidth; ++slot) {
    float relative[6];
    float near_t = -kNoBound, far_t = kNoBound;
    const Box box = node.box(slot);
    for (int axis = 0; axis < 3; ++axis) {
      float first = kNoBound, last = -kNoBound;
      for (int side = 0; side < 2; ++side) {
        const float at = (side == 0 ? box.lower[axis] : box.upper[axis]) - tile.origin[axis];
        relative[2 * axis + side] = at;
        for (const float inverse : {tile.inverse_min[axis], tile.inverse_max[axis]}) {
          first = std::min(first, at * inverse);
          last = std::max(last, at * inverse);
        }
      }
      near_t = std::max(near_t, first);
      far_t = std::min(far_t, last);
    }
    /// The largest (most) or smallest extent of the box along n.
    const auto reach = [&relative](const float* n, bool most) {
      float sum = 0.0f;
      for (int axis = 0; axis < 3; ++axis) sum += n[axis] * relative[2 * axis + ((n[axis] > 0.0f) == most ? 1 : 0)];
      return sum;
    };
    const float enter = std::max(near_t, 0.0f) * (1.0f - kSlabSlack);
    hits.bucket[slot] = std::max(bucket, depths.bucket_of(enter));
    hits.vectors[slot] = 0xFF;
    bool outside = enter > far_t * (1.0f + kSlabSlack);
    for (int p = 0; p < 4 && tile.narrow && !tile.grid; ++p) outside = outside || reach(tile.planes[p], true) < 0.0f;
    if (tile.grid) {
      const float near = reach(tile.along, false), far = reach(tile.along, true);
      if (near > 0.0f && far <= 2.0f * near) {
        const Covered x(reach(tile.across, false), reach(tile.across, true), 1.0f / near, 1.0f / far, tile.scale[0],
                        tile.margin);
        const Covered y(reach(tile.down, false), reach(tile.down, true), 1.0f / near, 1.0f / far, tile.scale[1],
                        tile.margin);
        outside = outside || x.first > x.last || y.first > y.last;
        if (!outside) hits.vectors[slot] = vectors_of(x.first, x.last, y.first, y.last);
      }
    }
    mask |= (outside ? 0u : 1u) << slot;
  }
  return mask & node.used;
}

void test_vector_portable(const TileGaussian&, const Box&, const TileRays&, unsigned, unsigned wanted, bool,
                          TileHits& hits) {
  hits.hit = 0;
  hits.unsure = wanted;
}

void test_pairs_portable(const TileStructure&, const TileRays&, const TilePair*, unsigned count, bool, TileHits& hits) {
  hits.hit = 0;
  hits.unsure = (1u << count) - 1u;
}

void colour_portable(const float* sh, unsigned coefficients, const TileBasis& basis, unsigned lane, float* rgb) {
  std::array<float, kShFunctions> functions;
  for (unsigned j = 0; j < coefficients; ++j) functions[j] = basis.values[j][lane];
  const glm::vec3 colour = sh_colour(sh, functions, coefficients);
  for (int c = 0; c < 3; ++c) rgb[c] = colour[c];
}

void colours_portable(const float* sh, unsigned coefficients, const TileBasis& basis, TileHits& hits) {
  for (unsigned lane = 0; lane < kTileLanes; ++lane) {
    float rgb[4];
    colour_portable(sh, coefficients, basis, lane, rgb);
    for (int c = 0; c < 3; ++c) hits.colour[c][lane] = rgb[c];
  }
}

}  // namespace

TileTests tile_tests(SimdPath path) {
#if defined(__x86_64__)
  if (path != SimdPath::portable) return tile_tests_avx2();
#endif
  static_cast<void>(path);
  return {test_node_portable,  test_outlines_portable, test_vector_portable,
          test_pairs_portable, colours_portable,       colour_portable};
}

}  // namespace grtx::frontend
