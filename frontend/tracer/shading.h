// SPDX-License-Identifier: Apache-2.0
// Blends the hits of a round: response, colour and transmittance, front to back, up to early ray termination.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "grtx/frontend/gaussian/canonical_hit.h"
#include "grtx/frontend/gaussian/gaussian_math.h"
#include "grtx/frontend/tracer/hit_records.h"
#include "grtx/frontend/tracer/ray_state.h"
#include "grtx/frontend/tracer/traced_structure.h"
#include "grtx/frontend/tracer/tracer_options.h"
#include "grtx/traces/event.h"

namespace grtx::frontend {

/// One per tracer.
class Shading {
 public:
  Shading(const TracedStructure& structure, const TracerOptions& options);

  /// When set, receives the ids blended by the rays traced from now on.
  void collect_blended(std::vector<std::uint32_t>* ids) { blended_ids_ = ids; }

  void begin_ray(const TraceRay& ray);
  /// Blends the entries of the k-buffer, which are sorted. Recorder: frontend/tracer/ray_recorder.h.
  template <typename Recorder>
  void blend(const TraceRay& ray, RayState& state, traces::Round& round, Recorder& recorder);

 private:
  void prefetch_colours(const KBuffer& hits) const;
  glm::vec3 colour_of(const KEntry& entry, const GaussianRecord& g, const TraceRay& ray, TracerCounters& counters);
  glm::vec3 colour_in_world(const KEntry& entry, const TraceRay& ray) const;
  void count_doubled(std::uint32_t gaussian, RayState& state);

  const Scene& scene_;
  const HitRecords records_;
  const MultiObjectWorld* const world_;
  const TracerOptions options_;
  const unsigned sh_degree_;  ///< the scene's: of the basis that is evaluated
  std::array<float, kShFunctions> basis_{};
  std::vector<std::uint64_t> processed_by_;  ///< by Gaussian: its last ray; empty unless stored triangles are tested
  std::vector<std::uint32_t>* blended_ids_ = nullptr;
};

}  // namespace grtx::frontend
