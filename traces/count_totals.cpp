#include "traces/count_totals.h"

#include <algorithm>
#include <array>

#include "traces/node_shape.h"

namespace grtx::traces {
namespace {

/// Events by kind, leaves by outcome: counted without a branch on what they are.
struct EventCounts {
  static constexpr std::size_t kLeaf = 16;  ///< + outcome
  std::array<std::uint64_t, 32> of{};
  std::uint64_t written = 0;

  void count(const Event& event) {
    const bool leaf = event.kind() == EventKind::visit_leaf;
    ++of[leaf ? kLeaf + (event.detail & 15U) : static_cast<std::size_t>(event.kind())];
    written += bits_of_byte(event.checkpoints);
  }
  std::uint64_t leaves(LeafOutcome outcome) const { return of[kLeaf + static_cast<std::size_t>(outcome)]; }
  std::uint64_t evicted() const { return leaves(LeafOutcome::displaced) + leaves(LeafOutcome::rejected); }
  void add_to(Totals& totals) const {
    const auto kind = [&](EventKind k) { return of[static_cast<std::size_t>(k)]; };
    totals.visits_internal += kind(EventKind::visit_internal);
    totals.visits_instance += kind(EventKind::visit_instance);
    for (std::size_t i = kLeaf; i < of.size(); ++i) {
      totals.visits_leaf += of[i];
      if (calls_any_hit(static_cast<LeafOutcome>(i - kLeaf))) totals.any_hit_calls += of[i];
    }
    totals.culls += kind(EventKind::cull);
    totals.checkpoints_read += kind(EventKind::replay_take) + kind(EventKind::replay_forward);
  }
};

void count_ray(const Header& header, const Ray& ray, Totals& totals) {
  ++totals.rays;
  totals.rounds += ray.rounds.size();
  totals.processed += ray.processed.size();
  for (const Processed& entry : ray.processed) totals.blended += entry.blended;
  std::uint64_t in_eviction_buffer = 0;
  std::size_t next = 0;
  for (const Round& round : ray.rounds) {
    EventCounts counts;
    for (const std::size_t end = next + round.event_count; next < end; ++next) counts.count(ray.events[next]);
    counts.add_to(totals);
    const std::uint64_t written = counts.written, evicted = counts.evicted();
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
