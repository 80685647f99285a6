// The tests of tile tracing: the boxes of a node against a tile, a Gaussian's outline against the rays of a tile, and
// the canonical hit function for eight rays at once. The first two may pass what is not hit, never the reverse; the
// third gives the bits of frontend/gaussian/canonical_hit.h. docs/model/tiles.md has the reasons.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "grtx/frontend/gaussian/gaussian_math.h"
#include "grtx/frontend/gaussian/simd_path.h"
#include "grtx/frontend/tiles/tile_rays.h"
#include "grtx/frontend/tiles/tile_structure.h"

namespace grtx::frontend {

/// Depths along the rays are cut into buckets that grow by a constant factor: the bits of non-negative floats count
/// like their logarithms. Bucket 0 ends where bucket 1 begins, the last one never.
struct TileDepths {
  static constexpr unsigned kBuckets = 1024;
  std::int32_t first = 0;  ///< bits of the float at which bucket 1 begins
  std::int32_t shift = 0;

  unsigned bucket_of(float t) const {
    const std::int32_t steps = (std::bit_cast<std::int32_t>(t) - first) >> shift;
    return static_cast<unsigned>(std::max(std::min(steps, static_cast<std::int32_t>(kBuckets) - 2) + 1, 0));
  }
};

/// What a tile may meet of a node's children.
struct alignas(32) TileNodeHits {
  std::uint32_t bucket[kTileNodeWidth];   ///< no hit inside lies in an earlier one
  std::uint32_t vectors[kTileNodeWidth];  ///< mask of the vectors of rays that may meet the child
};

/// Mask of the children that a ray of the tile may meet; the others' entries mean nothing. bucket: the node's own.
using TileNodeTest = unsigned (*)(const TileNode& node, const TileRays& tile, const TileDepths& depths,
                                  std::uint32_t bucket, TileNodeHits& hits);

/// A Gaussian that some rays may meet.
struct TileCandidate {
  std::uint64_t rays = 0;      ///< mask; before the outline test of vectors, after it of rays
  std::uint32_t gaussian = 0;  ///< in the structure
};

/// Leaves of each candidate's vectors the rays that may pass the Gaussian within its radius (d2 <= 1).
using TileOutlineTest = void (*)(const TileStructure& structure, const TileRays& tile, TileCandidate* candidates,
                                 std::size_t count);

struct alignas(32) TileHits {
  float t[kTileLanes];
  float alpha[kTileLanes];
  float colour[3][kTileLanes];
  unsigned hit = 0;     ///< lanes that hit and count, with t and alpha (fp32 response)
  unsigned unsure = 0;  ///< lanes that canonical_hit() has to decide
};

/// Lanes `wanted` of one vector against one Gaussian; leaves the colours alone. `sphere`: with t of the sphere's entry;
/// otherwise lanes with d2 <= 1 and an alpha that counts are left unsure.
using TileVectorTest = void (*)(const TileGaussian& g, const Box& box, const TileRays& tile, unsigned vector,
                                unsigned wanted, bool sphere, TileHits& hits);

struct TilePair {
  std::uint32_t gaussian = 0;  ///< in the structure
  std::uint32_t ray = 0;
};

/// The same of 1 to 8 pairs, pair by lane.
using TilePairTest = void (*)(const TileStructure& structure, const TileRays& tile, const TilePair* pairs,
                              unsigned count, bool sphere, TileHits& hits);

/// Functions of a vector's rays, by function and lane.
struct alignas(32) TileBasis {
  float values[kShFunctions][kTileLanes];
};

/// sh_colour() of a vector's rays.
using TileColours = void (*)(const float* sh, unsigned coefficients, const TileBasis& basis, TileHits& hits);
/// sh_colour() of one of them; rgb: with room for a fourth.
using TileColour = void (*)(const float* sh, unsigned coefficients, const TileBasis& basis, unsigned lane, float* rgb);

struct TileTests {
  TileNodeTest node;
  TileOutlineTest outlines;
  TileVectorTest vector;
  TilePairTest pairs;
  TileColours colours;
  TileColour colour;
};

/// The path must be available.
TileTests tile_tests(SimdPath path);

}  // namespace grtx::frontend
