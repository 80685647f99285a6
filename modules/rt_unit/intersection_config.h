// SPDX-License-Identifier: Apache-2.0
// Configuration and data paths of the intersection units: number of pipelines, latency, interval, and the operators of
// one pipeline, from which its area and energy follow.
#pragma once

#include <string>
#include <vector>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"

namespace grtx::modules {

struct IntersectionConfig {
  unsigned count = 4;
  unsigned latency = 13;
  unsigned interval = 1;
  /// what: the unit's name. origin: of all three values.
  void parameters(ParameterList& list, const std::string& what, Origin origin) {
    list.add("count", count, {1, 1024}, "pipelines", what + " pipelines of an RT unit", origin);
    list.add("latency", latency, {1, kMaxLatency}, "cycles", "from start to result", origin);
    list.add("interval", interval, {1, kMaxLatency}, "cycles", "between two starts of a pipeline", origin);
  }
};

// Defaults of the five units: number of pipelines, latency and interval (cycles between two starts of a pipeline).
inline constexpr IntersectionConfig kRayBoxUnit{4, 13, 1};
inline constexpr IntersectionConfig kRayTriangleUnit{4, 37, 1};
inline constexpr IntersectionConfig kRaySphereUnit = kRayTriangleUnit;  ///< no public source
inline constexpr IntersectionConfig kRayTransformUnit{4, 6, 1};
inline constexpr IntersectionConfig kRayGaussianUnit{4, 27, 1};

/// Hardware of one pipeline.
struct DataPath {
  std::vector<Operators> operators;  ///< for one test per cycle
  unsigned stage_bits = 0;           ///< mean register bits between two stages
};

// Operator counts from published data paths; register bits from synthesis with a register after each operator.
/// Slab tests of all children and their sort by t. decoded: the unit first decodes the quantised boxes.
DataPath ray_box_path(unsigned boxes, bool decoded = false);
DataPath ray_triangle_path();  ///< Moeller-Trumbore
DataPath ray_sphere_path();    ///< unit sphere at the origin
/// Affine transform of origin and direction. coded: the unit first decodes the map (layout quantised).
DataPath ray_transform_path(bool coded = false);
/// Peak of a Gaussian's response along a ray in its space, and its alpha. entry: t of the entry into its sphere as
/// well.
DataPath ray_gaussian_path(bool entry);

}  // namespace grtx::modules
