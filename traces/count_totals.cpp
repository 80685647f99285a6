#include "traces/count_totals.h"

#include <algorithm>
#include <bit>

namespace grtx::traces {
namespace {

void count_event(const Event& event, Totals& totals, std::uint64_t& written, std::uint64_t& evicted) {
  written += static_cast<unsigned>(std::popcount(event.checkpoints));
  switch (event.kind()) {
    case EventKind::visit_internal:
      ++totals.visits_internal;
      break;
    case EventKind::visit_instance:
      ++totals.visits_instance;
      break;
    case EventKind::visit_leaf:
      ++totals.visits_leaf;
      if (calls_any_hit(event.outcome())) ++totals.any_hit_calls;
      if (event.outcome() == LeafOutcome::displaced || event.outcome() == LeafOutcome::rejected) ++evicted;
      break;
    case EventKind::cull:
      ++totals.culls;
      break;
    case EventKind::replay_take:
    case EventKind::replay_forward:
      ++totals.checkpoints_read;
      break;
  }
}

void count_ray(const Header& header, const Ray& ray, Totals& totals) {
  ++totals.rays;
  totals.rounds += ray.rounds.size();
  totals.processed += ray.processed.size();
  for (const Processed& entry : ray.processed) totals.blended += entry.blended;
  std::uint64_t in_eviction_buffer = 0;
  std::size_t next = 0;
  for (const Round& round : ray.rounds) {
    std::uint64_t written = 0;
    std::uint64_t evicted = 0;
    for (const std::size_t end = next + round.event_count; next < end; ++next) {
      count_event(ray.events[next], totals, written, evicted);
    }
    totals.checkpoints_written += written;
    totals.max_checkpoints_per_round = std::max(totals.max_checkpoints_per_round, written);
    if (round.overflow) ++totals.overflows;
    if (!header.checkpoint) continue;  // what does not fit is found again by the next round
    totals.evictions += evicted;
    in_eviction_buffer -= std::min<std::uint64_t>(in_eviction_buffer, round.preloaded);
    in_eviction_buffer += evicted;
    totals.max_evictions_per_ray = std::max(totals.max_evictions_per_ray, in_eviction_buffer);
    in_eviction_buffer -= std::min<std::uint64_t>(in_eviction_buffer, round.eviction_dropped);
  }
}

}  // namespace

Totals count_totals(const Header& header, const RayGroup& group) {
  Totals totals;
  for (const Ray& ray : group.rays) count_ray(header, ray, totals);
  return totals;
}

void add_totals(Totals& to, const Totals& from) {
  to.rays += from.rays;
  to.rounds += from.rounds;
  to.visits_internal += from.visits_internal;
  to.visits_instance += from.visits_instance;
  to.visits_leaf += from.visits_leaf;
  to.culls += from.culls;
  to.any_hit_calls += from.any_hit_calls;
  to.evictions += from.evictions;
  to.checkpoints_written += from.checkpoints_written;
  to.checkpoints_read += from.checkpoints_read;
  to.overflows += from.overflows;
  to.processed += from.processed;
  to.blended += from.blended;
  to.max_checkpoints_per_round = std::max(to.max_checkpoints_per_round, from.max_checkpoints_per_round);
  to.max_evictions_per_ray = std::max(to.max_evictions_per_ray, from.max_evictions_per_ray);
}

}  // namespace grtx::traces
