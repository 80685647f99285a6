// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/tracer/ray_watch.h"

#include <bit>
#include <limits>

namespace grtx::frontend {

using traces::EventKind;
using traces::LeafOutcome;

void RayWatch::begin_ray(std::uint32_t pixel) {
  watched_ = WatchedRay();
  watched_.ray.pixel = pixel;
}

/// Stores a round's start at its first event, which changes neither k-buffer nor eviction buffer nor t_max.
void RayWatch::start() {
  begun_ = true;
  in_k_buffer_.clear();
  watched_.starts.push_back({state_.t_max, state_.hits.k_buffer().entries(), state_.hits.evictions().size()});
  watched_.ray.rounds.emplace_back();
}

void RayWatch::keep(EventKind kind, std::uint32_t address, unsigned detail, unsigned checkpoints, unsigned shifts) {
  if (!begun_) start();
  ++watched_.ray.rounds.back().event_count;
  watched_.ray.events.push_back({address, static_cast<std::uint8_t>(detail), static_cast<std::uint8_t>(checkpoints),
                                 traces::Event::pack(kind, shifts)});
  watched_.t_max.push_back(state_.t_max);
}

void RayWatch::internal(const Children&, std::uint32_t address, unsigned pushed, unsigned checkpoints) {
  keep(EventKind::visit_internal, address, pushed, checkpoints, 0);
  const auto push_count = static_cast<unsigned>(std::popcount(pushed));
  for (unsigned i = 0; i < push_count; ++i) watched_.times.push_back(stack_.from_top(i).t);
  const std::vector<StackEntry>& written = state_.checkpoints.written();
  for (auto i = static_cast<std::size_t>(std::popcount(checkpoints)); i > 0; --i) {
    watched_.times.push_back(written[written.size() - i].t);
  }
}

void RayWatch::event(EventKind kind, std::uint32_t address, unsigned detail, unsigned checkpoints, unsigned shifts) {
  keep(kind, address, detail, checkpoints, shifts);
  const auto outcome = static_cast<LeafOutcome>(detail);
  if (kind != EventKind::visit_leaf || outcome == LeafOutcome::miss) return;
  watched_.times.push_back(t_of_hit(outcome, checkpoints, shifts));
}

float RayWatch::t_of_hit(LeafOutcome outcome, unsigned checkpoints, unsigned shifts) {
  constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  const std::vector<KEntry>& hits = state_.hits.k_buffer().entries();
  switch (outcome) {
    case LeafOutcome::inserted:
    case LeafOutcome::displaced:
      if (!traces::collects_unsorted(options_.tracing)) {
        // A hit that is itself hidden lies at the end of the ray: it passed t_max, and not the hit that ends it.
        return shifts < checkpoints ? hits.back().t : hits[hits.size() + checkpoints - 1 - shifts].t;
      }
      for (const KEntry& hit : hits) {  // a heap, so the new one may be anywhere
        if (in_k_buffer_.insert(hit.id).second) return hit.t;
      }
      return kUnknown;
    case LeafOutcome::nearest:
      return hits.back().t;
    case LeafOutcome::rejected:
      if (options_.checkpoint) return state_.hits.evictions().back().t;
      if (options_.any_hit == AnyHit::delayed) return kUnknown;  // t_max does not tell
      return options_.tmax_update == TmaxUpdate::reported ? state_.t_max : kUnknown;
    case LeafOutcome::beyond:
      return checkpoints != 0 ? state_.checkpoints.written().back().t : kUnknown;
    default:
      return kUnknown;
  }
}

void RayWatch::end_round(traces::Round round) {
  if (!begun_) start();
  begun_ = false;
  round.event_count = watched_.ray.rounds.back().event_count;
  watched_.ray.rounds.back() = round;
  watched_.ray.bins = state_.checkpoints.bins();
  watched_.transmittance.push_back(state_.transmittance);
}

}  // namespace grtx::frontend
