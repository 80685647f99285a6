// SPDX-License-Identifier: Apache-2.0
// The rays of a trace that visit the most nodes: where to look with `grtx ray`. A trace has no time; `grtx sim
// --heatmap cycles` has it by pixel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "grtx/traces/event.h"
#include "grtx/traces/reader.h"

namespace grtx::experiment {

struct SlowRay {
  std::uint32_t x = 0, y = 0, frame = 0;
  traces::RayKind kind = traces::RayKind::primary;
  std::uint64_t warp = 0;
  std::uint64_t visits = 0;
  std::size_t rounds = 0;
};

struct SlowRays {
  std::vector<SlowRay> rays;  ///< the most visits first; of equal ones the first of the trace
  std::uint64_t median = 0;   ///< visits of the median ray that hit something
};

/// Nodes that a ray visits in all its rounds.
std::uint64_t visits_of(const traces::Ray& ray);

/// At most `count` of them.
SlowRays slowest_rays(const traces::Reader& reader, std::size_t count);

/// Visits of the median ray of a frame that hit something; of a large frame, of warps spread evenly over it. 0 without
/// such rays.
std::uint64_t median_visits(const traces::Reader& reader, std::uint32_t frame);

}  // namespace grtx::experiment
