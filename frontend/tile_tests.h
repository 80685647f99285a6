// The tests of tile tracing: the boxes of a node against a tile, a Gaussian's outline against the rays of a tile, and the
// canonical hit function for eight rays at once. The first two may pass what is not hit, never the reverse; the third
// gives the bits of frontend/canonical_hit.h. docs/tracer.md has the reasons.
#pragma once

#include <cstdint>

#include "frontend/simd_path.h"
#include "frontend/tile_rays.h"
#include "frontend/tile_structure.h"

namespace grtx::frontend {

/// What a tile may meet of a node's children.
struct alignas(32) TileNodeHits {
  float enter[kTileNodeWidth];           ///< no hit inside has a smaller t
  std::uint32_t vectors[kTileNodeWidth];  ///< mask of the vectors of rays that may meet the child
};

/// Mask of the children that a ray of the tile may meet; the others' entries mean nothing.
using TileNodeTest = unsigned (*)(const TileNode& node, const TileRays& tile, TileNodeHits& hits);

/// Which rays of `wanted` vectors may pass the Gaussian within its radius (d2 <= 1).
using TileOutlineTest = std::uint64_t (*)(const TileGaussian& g, const TileRays& tile, unsigned wanted);

struct alignas(32) TileHits {
  float t[kTileLanes];
  float d2[kTileLanes];
  float alpha[kTileLanes];
  unsigned hit = 0;     ///< lanes that hit, with t, d2 and alpha (fp32 response)
  unsigned unsure = 0;  ///< lanes that canonical_hit() has to decide
};

/// Lanes `wanted` of one vector. `sphere`: with t of the sphere's entry; otherwise lanes with d2 <= 1 and an alpha that
/// counts are left unsure.
using TileHitTest = void (*)(const TileGaussian& g, const Box& box, const TileRays& tile, unsigned vector,
                             unsigned wanted, bool sphere, TileHits& hits);

/// A hit of a ray, ready to be blended.
struct TileHit {
  std::uint64_t order = 0;  ///< bits of t (never negative), then id: compares as (t, id)
  float alpha = 0.0f;
  std::uint32_t gaussian = 0;  ///< in the structure
};

/// Light gathered by a ray so far.
struct alignas(16) TileLight {
  float colour[4] = {0.0f, 0.0f, 0.0f, 0.0f};
  float transmittance = 1.0f;
};

/// Blends a ray's next hits, sorted, until its transmittance falls below `ert`; returns how many. `basis`: of the ray,
/// coefficients() functions.
using TileBlend = unsigned (*)(const TileHit* hits, unsigned count, const float* basis, const TileStructure& structure,
                               float ert, TileLight& light);

struct TileTests {
  TileNodeTest node;
  TileOutlineTest outline;
  TileHitTest hit;
  TileBlend blend;
};

/// The path must be available.
TileTests tile_tests(SimdPath path);

}  // namespace grtx::frontend
