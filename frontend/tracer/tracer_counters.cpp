// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/tracer/tracer_counters.h"

#include <algorithm>

namespace grtx::frontend {
namespace {

using declare::StatisticKind;

double share(std::uint64_t part, std::uint64_t whole) {
  return static_cast<double>(part) / static_cast<double>(std::max<std::uint64_t>(1, whole));
}

// Only where hits were counted.
void describe_hits(const TracerCounters& c, declare::StatisticList& list, const std::string& prefix) {
  if (!c.hits) return;
  list.add(prefix + ".hits", *c.hits, "hits", "proxy hits of all rays, those behind early ray termination included",
           StatisticKind::count);
  list.add(prefix + ".hits_behind_end", c.hits_behind_end(), "ratio",
           "tracer.hits / tracer.processed: hits that rays have for each that they process", StatisticKind::ratio);
}

void add_opacity(std::optional<OpacityCounts>& total, const std::optional<OpacityCounts>& more) {
  if (!more) return;
  const OpacityCounts before = total.value_or(OpacityCounts());
  total = {before.rays + more->rays, before.hidden + more->hidden, before.hits + more->hits,
           before.nodes + more->nodes};
}

// Only with --opacity-bound.
void describe_opacity(const TracerCounters& c, declare::StatisticList& list, const std::string& prefix) {
  if (!c.opacity) return;
  list.add(prefix + ".opacity.rays", c.opacity->rays, "rays",
           "rays whose end moved to where the hits found let no light through", StatisticKind::count);
  list.add(prefix + ".opacity.hidden", c.opacity->hidden, "hits", "entries behind that end that left the k-buffer",
           StatisticKind::count);
  list.add(prefix + ".opacity.hits", c.opacity->hits, "hits",
           "leaves visited whose hit lies behind it: no any-hit shader", StatisticKind::count);
  list.add(prefix + ".opacity.nodes", c.opacity->nodes, "nodes",
           "nodes behind it: children not pushed, popped nodes not visited, neither checkpointed",
           StatisticKind::count);
}

}  // namespace

double TracerCounters::ert_share() const { return share(terminated, rays); }
double TracerCounters::hits_behind_end() const { return share(hits.value_or(0), processed); }

const declare::CounterTable<TracerCounters>& TracerCounters::table() {
  using C = TracerCounters;
  static const auto table =
      declare::CounterTable<C>()
          .sum(&C::rays, "rays", "rays", "rays traced, secondary ones included")
          .sum(&C::rounds, "rounds", "rounds", "traceRay calls, summed over rays")
          .sum(&C::visits_internal, "visits.internal", "visits", "internal nodes processed by a ray")
          .sum(&C::visits_instance, "visits.instance", "visits",
               "instance leaves processed, replay transforms included")
          .sum(&C::visits_leaf, "visits.leaf", "visits", "primitive leaves processed")
          .value(&C::visits, "visits.total", "visits", "nodes processed, all kinds", StatisticKind::count)
          .sum(&C::visits_unique, "visits.unique", "visits", "distinct nodes per ray, summed over rays")
          .value(&C::any_hit_calls, "any_hit.calls", "calls", "any-hit shader invocations", StatisticKind::count)
          .sum(&C::any_hit_inserted, "any_hit.inserted", "calls", "hits that entered the k-buffer")
          .sum(&C::any_hit_evicted, "any_hit.evicted", "hits", "hits that left or did not enter a full k-buffer")
          .sum(&C::any_hit_rejected, "any_hit.rejected", "calls", "hits that did not fit and were reported")
          .sum(&C::any_hit_ignored, "any_hit.ignored", "calls", "ties at the resume point that were already blended")
          .sum(&C::checkpoints_written, "checkpoint.written", "entries", "checkpoint entries written")
          .sum(&C::checkpoints_read, "checkpoint.read", "entries", "checkpoint entries read")
          .largest(&C::checkpoints_max_per_ray, "checkpoint.max_per_ray", "entries",
                   "most entries in one buffer of a ray")
          .sum(&C::checkpoint_overflows, "checkpoint.overflows", "rounds", "rounds whose destination buffer ran full")
          .largest(&C::evictions_max_per_ray, "eviction.max_per_ray", "entries", "most entries in one eviction buffer")
          .sum(&C::processed, "processed", "hits", "k-buffer entries processed for blending")
          .sum(&C::blended, "blended", "hits", "hits blended into a pixel")
          .sum(&C::terminated, "terminated", "rays", "rays ended by early ray termination")
          .share({"terminated", &C::terminated}, {"rays", &C::rays}, "ert_share", "ratio",
                 "rays ended by early ray termination / rays")
          .own(&C::hits,
               [](auto& total, const auto& more) {
                 if (more) total = total.value_or(0) + *more;
               })
          .described(describe_hits)
          .sum(&C::ties_lost, "ties_lost", "hits", "ties at the resume point lost by --resume strict")
          .sum(&C::inside_skipped, "inside_skipped", "hits", "Gaussians skipped because their proxy holds the origin")
          .own(&C::opacity, add_opacity)
          .described(describe_opacity)
          .sum(&C::single_overflows, "single.overflows", "rounds",
               "single-round and list: a hit met a full buffer of k hits")
          .sum(&C::nearest_commits, "nearest_commits", "hits", "closest-hit: hits that became the nearest so far")
          .sum(&C::doubled, "doubled", "hits", "--triangle-test world: Gaussians processed by a ray once more")
          .sum(&C::skipped_retests, "skipped.retests", "tests", "left out: nodes that the ray had tested before")
          .sum(&C::skipped_dead_colours, "skipped.dead_colours", "colours",
               "left out: of hits behind the one that ended a ray")
          .sum(&C::skipped_sh_bands, "skipped.sh_bands", "coefficients", "left out: above the scene's degree")
          .sum(&C::skipped_scene_misses, "skipped.scene_misses", "rays",
               "left out: rays that miss all boxes of the root")
          .sum(&C::skipped_events, "skipped.events", "visits", "left out: visits that no trace asked for");
  return table;
}

}  // namespace grtx::frontend
