// SPDX-License-Identifier: Apache-2.0
#include "grtx/traces/count_totals.h"

#include <algorithm>
#include <numeric>

#include "grtx/traces/codec/node_shape.h"
#include "grtx/traces/rules/round_rules.h"

namespace grtx::traces {

// Counts in one cell per kind and detail, without branches, since the sequence of events is unpredictable.
void RoundCounts::count(std::span<const Event> events) {
  constexpr std::size_t kDetails = 8;
  std::array<std::uint32_t, 16 * kDetails> cells{};
  for (const Event& event : events) {
    ++cells[static_cast<std::size_t>(event.kind()) * kDetails + event.detail % kDetails];
    written += bits_of_byte(event.written());
  }
  const auto cells_of = [&](EventKind kind) { return &cells[static_cast<std::size_t>(kind) * kDetails]; };
  const auto sum = [](const std::uint32_t* first) {
    return std::accumulate(first, first + kDetails, std::uint64_t{0});
  };
  internal = sum(cells_of(EventKind::visit_internal));
  instances = sum(cells_of(EventKind::visit_instance));
  std::copy_n(cells_of(EventKind::visit_leaf), kDetails, leaves.begin());
  culls = sum(cells_of(EventKind::cull));
  read = events.size() - internal - instances - sum(cells_of(EventKind::visit_leaf)) - culls;
}

void count_round(const Header& header, const Round& round, const RoundCounts& counts, std::uint64_t& in_eviction_buffer,
                 Totals& totals) {
  ++totals.rounds;
  totals.visits_internal += counts.internal;
  totals.visits_instance += counts.instances;
  for (std::size_t i = 0; i < counts.leaves.size(); ++i) {
    totals.visits_leaf += counts.leaves[i];
    if (calls_any_hit(static_cast<LeafOutcome>(i))) totals.any_hit_calls += counts.leaves[i];
  }
  totals.culls += counts.culls;
  totals.checkpoints_read += counts.read;
  totals.checkpoints_written += counts.written;
  totals.max_checkpoints_per_round = std::max(totals.max_checkpoints_per_round, counts.written);
  if (round.overflow) ++totals.overflows;
  if (!header.checkpoint) return;  // no eviction buffer: the next round finds these hits again
  std::uint64_t evicted = 0;
  for (std::size_t i = 0; i < counts.leaves.size(); ++i) {
    if (evicts(static_cast<LeafOutcome>(i))) evicted += counts.leaves[i];
  }
  totals.evictions += evicted;
  in_eviction_buffer -= std::min<std::uint64_t>(in_eviction_buffer, round.preloaded);
  in_eviction_buffer += evicted;
  totals.max_evictions_per_ray = std::max(totals.max_evictions_per_ray, in_eviction_buffer);
  in_eviction_buffer -= std::min<std::uint64_t>(in_eviction_buffer, round.eviction_dropped);
}

Totals count_totals(const Header& header, const RayGroup& group) {
  Totals totals;
  for (const Ray& ray : group.rays) {
    ++totals.rays;
    totals.processed += ray.processed.size();
    for (const Processed& entry : ray.processed) totals.blended += entry.blended;
    std::uint64_t in_eviction_buffer = 0;
    std::size_t next = 0;
    for (const Round& round : ray.rounds) {
      RoundCounts counts;
      counts.count({ray.events.data() + next, round.event_count});
      next += round.event_count;
      count_round(header, round, counts, in_eviction_buffer, totals);
    }
  }
  return totals;
}

void add_totals(Totals& to, const Totals& from) {
  for (const TotalField& field : kTotalFields) {
    std::uint64_t& sum = to.*field.value;
    sum = field.largest ? std::max(sum, from.*field.value) : sum + from.*field.value;
  }
}

}  // namespace grtx::traces
