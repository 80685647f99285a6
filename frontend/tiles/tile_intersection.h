// SPDX-License-Identifier: Apache-2.0
// The tests of tile tracing: the boxes of a node against a tile, a Gaussian's outline against the rays of a tile, and
// the canonical hit function for eight rays at once. The first two are conservative: they may pass a miss, but never
// reject a hit. The third gives the bits of frontend/gaussian/canonical_hit.h. Reasons: docs/model/tiles.md.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "grtx/frontend/gaussian/gaussian_math.h"
#include "grtx/frontend/gaussian/simd_path.h"
#include "grtx/frontend/tiles/tile_rays.h"
#include "grtx/frontend/tiles/tile_structure.h"

namespace grtx::frontend {

/// Divides depths along the rays into buckets that grow by a constant factor: the bits of a non-negative float grow
/// like its logarithm. Bucket 0 ends where bucket 1 begins; the last one has no end.
struct TileDepths {
  static constexpr unsigned kBuckets = 1024;
  std::int32_t first = 0;  ///< bits of the float at which bucket 1 begins
  std::int32_t shift = 0;

  unsigned bucket_of(float t) const {
    const std::int32_t steps = (std::bit_cast<std::int32_t>(t) - first) >> shift;
    return static_cast<unsigned>(std::max(std::min(steps, static_cast<std::int32_t>(kBuckets) - 2) + 1, 0));
  }
};

/// Result of testing a tile against a node's children.
struct alignas(32) TileNodeHits {
  std::uint32_t bucket[kTileNodeWidth];   ///< no hit inside the child is in an earlier bucket
  std::uint32_t vectors[kTileNodeWidth];  ///< mask of the vectors with rays that may hit the child
};

/// Returns the mask of children that a ray of the tile may hit; others have no valid entries. bucket: the node's own.
using TileNodeTest = unsigned (*)(const TileNode& node, const TileRays& tile, const TileDepths& depths,
                                  std::uint32_t bucket, TileNodeHits& hits);

/// A Gaussian that some rays may hit.
struct TileCandidate {
  std::uint64_t rays = 0;      ///< mask: of vectors before the outline test, of rays after it
  std::uint32_t gaussian = 0;  ///< index in the structure
};

/// Reduces each candidate's vectors to the rays that may pass the Gaussian within its radius (d2 <= 1).
using TileOutlineTest = void (*)(const TileStructure& structure, const TileRays& tile, TileCandidate* candidates,
                                 std::size_t count);

struct alignas(32) TileHits {
  float t[kTileLanes];
  float alpha[kTileLanes];
  float colour[3][kTileLanes];
  unsigned hit = 0;     ///< lanes with a hit whose alpha counts; t and alpha are set (fp32 response)
  unsigned unsure = 0;  ///< lanes for which canonical_hit() must decide
};

/// Tests the lanes `wanted` of one vector against one Gaussian; does not set colours. `sphere`: computes t of the
/// sphere's entry; otherwise lanes with d2 <= 1 and an alpha that counts are left unsure.
using TileVectorTest = void (*)(const TileGaussian& g, const Box& box, const TileRays& tile, unsigned vector,
                                unsigned wanted, bool sphere, TileHits& hits);

struct TilePair {
  std::uint32_t gaussian = 0;  ///< index in the structure
  std::uint32_t ray = 0;
};

/// The same for 1 to 8 pairs, one per lane.
using TilePairTest = void (*)(const TileStructure& structure, const TileRays& tile, const TilePair* pairs,
                              unsigned count, bool sphere, TileHits& hits);

/// SH basis functions of a vector's rays, by function and lane.
struct alignas(32) TileBasis {
  float values[kShFunctions][kTileLanes];
};

/// sh_colour() of all rays of a vector.
using TileColours = void (*)(const float* sh, unsigned coefficients, const TileBasis& basis, TileHits& hits);
/// sh_colour() of one ray; rgb: has room for a fourth value.
using TileColour = void (*)(const float* sh, unsigned coefficients, const TileBasis& basis, unsigned lane, float* rgb);

struct TileTests {
  TileNodeTest node;
  TileOutlineTest outlines;
  TileVectorTest vector;
  TilePairTest pairs;
  TileColours colours;
  TileColour colour;
};

/// The tests for a path, which must be available.
TileTests tile_tests(SimdPath path);

}  // namespace grtx::frontend
