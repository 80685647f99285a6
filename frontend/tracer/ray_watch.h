// SPDX-License-Identifier: Apache-2.0
// A recorder that keeps one ray as in a trace, and with each event what a trace omits: t_max, and the t of what was
// pushed, checkpointed or hit. It reads them from the tracer's own state and computes nothing.
#pragma once

#include <cstdint>
#include <set>
#include <vector>

#include "grtx/frontend/tracer/ray_recorder.h"
#include "grtx/frontend/tracer/ray_state.h"
#include "grtx/frontend/tracer/tracer_options.h"
#include "grtx/frontend/tracer/traversal_stack.h"
#include "grtx/traces/event.h"

namespace grtx::frontend {

/// Record of a watched ray. Events of internal nodes have their address, in units. With several nodes under way events
/// stand in the order in which the ray came to them.
struct WatchedRay {
  traces::Ray ray;
  std::vector<float> t_max;  ///< after each event
  /// The t values of each event, in order. visit_internal: entry t of the pushed children, the next to be popped first,
  /// then of the checkpointed ones, in slot order. visit_leaf except for a miss: t of the hit; NaN if the tracer does
  /// not keep it.
  std::vector<float> times;
  struct Start {
    float t_max = 0.0f;
    std::vector<KEntry> k_buffer;
    std::size_t evictions = 0;  ///< left in the eviction buffer
  };
  std::vector<Start> starts;         ///< start of each round
  std::vector<float> transmittance;  ///< after each round
};

class RayWatch {
 public:
  static constexpr bool kEnabled = true;
  static constexpr bool kDepthFirst = false;
  using Children = NullRecorder::Children;

  /// state, stack: of the tracer that will get this recorder.
  RayWatch(const TracerOptions& options, const RayState& state, const TraversalStack& stack)
      : options_(options), state_(state), stack_(stack) {}

  /// Discards the previous ray.
  void begin_ray(std::uint32_t pixel);
  const WatchedRay& watched() const { return watched_; }

  // Called by the tracer.
  void bins(const std::vector<std::uint8_t>&) {}
  void begin_round(bool /*replay*/, traces::BinOrder /*order*/ = {}) { begun_ = false; }
  template <typename Place>
  void at(const Place&) {}
  std::uint32_t last() const { return 0; }
  void pop() {}
  Children open(std::uint32_t /*address*/) { return {}; }
  void internal(const Children&, std::uint32_t address, unsigned pushed, unsigned checkpoints);
  void event(traces::EventKind kind, std::uint32_t address, unsigned detail, unsigned checkpoints, unsigned shifts = 0);
  void processed(std::uint32_t gaussian, bool blended) {
    watched_.ray.processed.push_back(processed_entry(gaussian, blended));
  }
  void end_round(traces::Round round);

 private:
  void start();
  void keep(traces::EventKind kind, std::uint32_t address, unsigned detail, unsigned checkpoints, unsigned shifts);
  float t_of_hit(traces::LeafOutcome outcome, unsigned checkpoints, unsigned shifts);

  const TracerOptions& options_;
  const RayState& state_;
  const TraversalStack& stack_;
  WatchedRay watched_;
  bool begun_ = false;                   ///< the round has had an event
  std::set<std::uint32_t> in_k_buffer_;  ///< single, list: ids inserted in this round
};

}  // namespace grtx::frontend
