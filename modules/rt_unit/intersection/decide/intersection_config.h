// SPDX-License-Identifier: Apache-2.0
// Keys, counters and data paths of the intersection units: number of pipelines, latency, interval, and the operators
// of one pipeline, from which its area and energy follow.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/rt_unit/part/part_info.h"

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
/// The five units' rows in the table of all parts.
PartInfo ray_box_info(const IntersectionConfig& config);
PartInfo ray_triangle_info(const IntersectionConfig& config);
PartInfo ray_sphere_info(const IntersectionConfig& config);
PartInfo ray_gaussian_info(const IntersectionConfig& config);
PartInfo ray_transform_info(const IntersectionConfig& config);

// Defaults of the five units: number of pipelines, latency and interval (cycles between two starts of a pipeline).
inline constexpr IntersectionConfig kRayBoxUnit{4, 13, 1};
inline constexpr IntersectionConfig kRayTriangleUnit{4, 37, 1};
inline constexpr IntersectionConfig kRaySphereUnit = kRayTriangleUnit;  ///< no public source
inline constexpr IntersectionConfig kRayTransformUnit{4, 6, 1};
inline constexpr IntersectionConfig kRayGaussianUnit{4, 27, 1};

/// How tests come to a unit: its queue, and what it reads for them.
struct TestInput {
  std::uint64_t places = 0;  ///< of the queue; 0: one for each lane of the warp buffer
  unsigned name_bits = 8;    ///< of a test in the queue
  unsigned ray_banks = 0;    ///< lane l's ray lies in bank l mod so many, each read once a cycle; 0: no limit
  unsigned node_ports = 0;   ///< nodes whose tests start in a cycle; 0: no limit
};

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
/// Peak of a Gaussian's response along a ray in the Gaussian's space, and alpha. entry: also t of the entry into its
/// sphere.
DataPath ray_gaussian_path(bool entry);

struct IntersectionCounters {
  std::uint64_t operations = 0;    ///< lane operations started
  std::uint64_t tests = 0;         ///< tests of these operations (an operation may have several, e.g. one per child)
  std::uint64_t busy_cycles = 0;   ///< pipeline-cycles in which no further test could start: tests x interval
  std::uint64_t queue_cycles = 0;  ///< cycles that lanes waited in the queue beyond the first
  std::uint64_t queue_max = 0;     ///< longest queue
  static const CounterTable<IntersectionCounters>& table();
  void add(const IntersectionCounters& other) { table().add(*this, other); }
  void describe(StatisticList& list, const std::string& prefix) const { table().describe(*this, list, prefix); }
};

}  // namespace grtx::modules
