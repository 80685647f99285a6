// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/tracer/ray_tracer.h"

#include <algorithm>

#include "grtx/frontend/tracer/encoding_recorder.h"
#include "grtx/frontend/tracer/ray_watch.h"

namespace grtx::frontend {

RayTracer::RayTracer(const TracedStructure& structure, const TracerOptions& options)
    :  // The peak of a polyhedron's Gaussian may lie beyond its entry face's box, so only entry keys allow this cull.
      cull_before_(options.sort_key == SortKey::entry),
      replay_below_kth_(options.replay_tmax == ReplayTmax::kth),
      state_(options),
      traversal_(structure, options),
      shading_(structure, options) {}

template <typename Recorder>
RayResult RayTracer::trace(const TraceRay& ray, Recorder& recorder, float transmittance, float t_limit) {
  state_.begin_ray(transmittance, t_limit);
  shading_.begin_ray(ray);
  traversal_.begin_ray(ray);
  state_.checkpoints.measure_from(traversal_.scene_enter(ray));
  recorder.bins(state_.checkpoints.bins());
  if (traversal_.misses_scene(ray)) {
    traversal_.miss_scene(state_, recorder);
    return {state_.colour, state_.transmittance};
  }
  const std::uint64_t visits_before = state_.counters.visits();
  traces::Round round;
  do {
    round = begin_round(recorder);
    traversal_.round(ray, state_, recorder);
  } while (end_round(ray, round, recorder));
  if (state_.ends_early()) ++state_.counters.opacity->rays;
  if (!Recorder::kEnabled) state_.counters.skipped_events += state_.counters.visits() - visits_before;
  return {state_.colour, state_.transmittance};
}

template <typename Recorder>
traces::Round RayTracer::begin_round(Recorder& recorder) {
  traces::Round round;
  round.replay = state_.replay;
  ++state_.counters.rounds;
  state_.checkpoints.begin_round(state_.replay);
  state_.turned_away = false;
  if (state_.replay) round.bins = state_.checkpoints.bin_order();
  recorder.begin_round(state_.replay, round.bins);
  round.preloaded = static_cast<std::uint16_t>(state_.hits.begin_round(state_.transmittance, state_.t_limit));
  state_.t_max = state_.t_limit;
  if (replay_below_kth_ && state_.hits.k_buffer().full()) {
    state_.t_max = std::min(state_.t_max, state_.hits.k_buffer().last().t);
  }
  state_.t_min_cull = cull_before_ ? std::max(state_.t_last, 0.0f) : 0.0f;
  return round;
}

/// Blends what the round has found. False: it was the ray's last.
template <typename Recorder>
bool RayTracer::end_round(const TraceRay& ray, traces::Round& round, Recorder& recorder) {
  TracerCounters& counters = state_.counters;
  traces::RoundHits<KEntry>& hits = state_.hits;
  counters.evictions_max_per_ray = std::max<std::uint64_t>(counters.evictions_max_per_ray, hits.evictions().size());
  round.overflow = state_.checkpoints.overflow();
  state_.checkpoints.end_round(state_.t_max);
  round.k_count = static_cast<std::uint16_t>(hits.k_buffer().size());
  hits.end_round();
  if (state_.turned_away && !hits.rules().sorted()) ++counters.single_overflows;
  shading_.blend(ray, state_, round, recorder);
  counters.checkpoints_max_per_ray =
      std::max<std::uint64_t>(counters.checkpoints_max_per_ray, state_.checkpoints.held());
  if (round.overflow) {
    ++counters.checkpoint_overflows;
    round.eviction_dropped = static_cast<std::uint32_t>(hits.evictions().size());
    hits.drop_evictions();
    state_.checkpoints.drop_written();
  }
  recorder.end_round(round);
  if (round.terminated) ++counters.terminated;
  if (!hits.rules().goes_on(round)) return false;
  const KEntry& last = hits.k_buffer().entries().back();  // the largest in every mode: the round is over
  state_.t_last = last.t;
  state_.id_last = last.id;
  state_.replay = hits.rules().replays_after(round);
  return true;
}

template RayResult RayTracer::trace(const TraceRay&, NullRecorder&, float, float);
template RayResult RayTracer::trace(const TraceRay&, GroupRecorder&, float, float);
template RayResult RayTracer::trace(const TraceRay&, EncodingRecorder&, float, float);
template RayResult RayTracer::trace(const TraceRay&, RayWatch&, float, float);

}  // namespace grtx::frontend
