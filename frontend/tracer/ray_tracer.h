// SPDX-License-Identifier: Apache-2.0
// Traces one ray: round after round of traversal, each followed by blending, until the ray ends. Ray state, traversal,
// hit policy and shading have files of their own.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

#include "grtx/frontend/tracer/ray_recorder.h"
#include "grtx/frontend/tracer/ray_state.h"
#include "grtx/frontend/tracer/shading.h"
#include "grtx/frontend/tracer/traced_structure.h"
#include "grtx/frontend/tracer/tracer_options.h"
#include "grtx/frontend/tracer/traversal.h"

namespace grtx::frontend {

struct RayResult {
  glm::vec3 colour{0.0f};
  float transmittance = 1.0f;
};

/// One per thread; holds the buffers of the ray being traced.
class RayTracer {
 public:
  RayTracer(const Scene& scene, const PreparedGaussians& gaussians, const AccelerationStructure& accel,
            const TracerOptions& options)
      : RayTracer(TracedStructure(scene, gaussians, accel), options) {}
  /// With several objects, Gaussian ids are those of the whole scene; recorders get record numbers.
  RayTracer(const TracedStructure& structure, const TracerOptions& options);

  const TracerCounters& counters() const { return state_.counters; }
  /// State and stack of the ray being traced, for RayWatch.
  const RayState& state() const { return state_; }
  const TraversalStack& stack() const { return traversal_.stack(); }
  void track_visits(VisitTracker* tracker) { traversal_.track_visits(tracker); }
  /// When set, receives the ids blended by the rays traced from now on.
  void collect_blended(std::vector<std::uint32_t>* ids) { shading_.collect_blended(ids); }

  /// The light that reaches the ray's origin from hits with t <= t_limit, dimmed by `transmittance` (at the origin,
  /// after earlier pieces of the path), and the transmittance that remains. Nothing beyond t_limit is pushed or
  /// checkpointed. For NullRecorder, GroupRecorder, EncodingRecorder and RayWatch.
  template <typename Recorder>
  RayResult trace(const TraceRay& ray, Recorder& recorder, float transmittance = 1.0f,
                  float t_limit = std::numeric_limits<float>::infinity());

 private:
  template <typename Recorder>
  traces::Round begin_round(Recorder& recorder);
  template <typename Recorder>
  bool end_round(const TraceRay& ray, traces::Round& round, Recorder& recorder);

  const bool cull_before_;       ///< boxes that end before the last blended hit are skipped
  const bool replay_below_kth_;  ///< ReplayTmax::kth: t_max of a round that begins with a full k-buffer
  RayState state_;
  Traversal traversal_;
  Shading shading_;
};

}  // namespace grtx::frontend
