// SPDX-License-Identifier: Apache-2.0
// The rays of a tile of pixels as arrays for vector instructions, and their bounds: common origin, range of reciprocal
// directions, four planes, and coordinates in which a Gaussian's outline is a conic.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>

#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/gaussian/canonical_hit.h"

namespace grtx::frontend {

inline constexpr unsigned kTileEdge = 8;  ///< pixels
inline constexpr unsigned kTileRays = kTileEdge * kTileEdge;
inline constexpr unsigned kTileLanes = 8;  ///< rays of a vector: 4x2 pixels
inline constexpr unsigned kTileVectors = kTileRays / kTileLanes;

/// Ray r of a tile is lane r % 8 of vector r / 8, and bit r of a mask of rays.
struct TileRays {
  TileRays() = default;
  /// The tile whose first pixel is (x, y). Pixels outside the image and pixels without a direction have no live ray;
  /// their lanes repeat a live one.
  TileRays(const Camera& camera, const glm::vec3& camera_origin, unsigned x, unsigned y);
  TileRays(const TileRays&) = delete;

  glm::vec3 origin{0.0f};
  std::uint64_t live = 0;
  std::array<std::uint32_t, kTileRays> pixel{};  ///< index in the image; of live rays
  std::array<TraceRay, kTileRays> rays{};

  alignas(32) std::array<float, kTileRays> direction[3];
  alignas(32) std::array<float, kTileRays> inverse[3];  ///< SlabRay::inverse
  alignas(32) std::array<float, kTileRays> inverse_length2;

  /// The same, one row per ray: direction, inverse_length2, inverse, 0.
  alignas(32) float packed[kTileRays][8];

  float inverse_min[3];
  float inverse_max[3];

  /// True if all rays are within about 84 degrees of the tile's axis: required for the following members.
  bool narrow = false;
  /// Columns axis, right, down (orthonormal, fp32-rounded) by row; the last entry of a row is 0.
  alignas(16) float frame[3][4];
  /// By ray: its direction is a positive multiple of axis + u right + v down.
  alignas(32) std::array<float, kTileRays> u;
  alignas(32) std::array<float, kTileRays> v;
  float extent2 = 0.0f;  ///< the largest u^2 or v^2
  /// n . direction >= kPlaneTilt for all rays.
  float planes[4][3];

  /// True if the rays are on a grid, as a pinhole's are: for p = x - origin, ray (i, j) has p . across / p . along *
  /// scale[0] + 3.5 = i, and j likewise with down.
  bool grid = false;
  float across[3];
  float down[3];
  float along[3];
  float scale[2];  ///< pixels
  float margin;    ///< pixels: bound on fp32 rounding in this and in a test of a box against it

 private:
  void bound(const Camera& camera);
  void find_grid(const Camera& camera, unsigned x, unsigned y);
};

/// Rays keep this distance (sine of an angle) from the planes around their tile. It covers fp32 rounding in a test of a
/// box against a plane, which is below 2^-20 of the box's distance from the origin.
inline constexpr double kPlaneTilt = 1.0 / (1 << 17);

/// Columns and rows of a tile (from its first pixel) and lanes: ray r is pixel (tile_x(r), tile_y(r)).
constexpr unsigned tile_x(unsigned ray) { return ray / kTileLanes % 2 * 4 + ray % 4; }
constexpr unsigned tile_y(unsigned ray) { return ray / kTileLanes / 2 * 2 + ray % kTileLanes / 4; }

}  // namespace grtx::frontend
