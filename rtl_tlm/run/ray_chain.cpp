// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/run/ray_chain.h"

#include <algorithm>
#include <array>
#include <vector>

namespace grtx::sim {

ChainLatencies::ChainLatencies(const GpuConfig& config, const traces::Header& header) {
  const modules::RtUnitConfig& rt = config.rt;
  // Merging with a fetch under way can be faster than a hit: then the fetch counts 0. Else one cycle from a scheduled
  // warp to its request, one from the response to the unit's start, and the fastest answer between: an L1 hit; a miss,
  // answered as soon as the L2 answers; or joining another warp's miss or a prefetch a cycle before the sector comes.
  const Cycle merged = config.l1.mshr_merges > 1 ? 1 + config.sm_links.l1_latency : modules::kNever;
  const Cycle fastest_answer = std::min({Cycle{config.l1.latency}, Cycle{config.l2.latency}, merged});
  const Cycle to_the_l1 = rt.memory.asks_at_once() ? 0 : config.sm_links.l1_latency;
  const Cycle l1_round_trip = 1 + std::min(to_the_l1 + fastest_answer, Cycle{rt.memory.l1_hit_latency});
  const Cycle fetch = rt.memory.merge_in_flight ? 0 : l1_round_trip;
  internal = fetch + 1 + rt.ray_box.latency;
  instance = fetch + 1 + rt.ray_transform.latency;
  leaf = fetch + 1 + rt.leaf_unit(header).latency;
  const Cycle messages = 2 * Cycle{config.sm_links.message_latency};
  const modules::ShaderCosts& cost = config.simt.costs;
  const bool boxes = traces::has_box_leaves(header.accel);
  const Cycle intersection = messages + cost.call(1) + cost.intersection_fixed +
                             (header.two_level ? 0 : cost.intersection_transform) + config.simt.instruction_latency;
  if (boxes) leaf = fetch + intersection;
  any_hit = rt.any_hit_unit.enabled
                ? Cycle{rt.any_hit_unit.latency}
                : (boxes ? 0 : messages + cost.call(1)) + cost.any_hit_fixed + config.simt.instruction_latency;
  // A warp has a node once: its fetch merges with no other of the warp's.
  if (rt.walks()) walk.emplace(rt, header, rt.memory.by_shader ? 0 : l1_round_trip, boxes ? intersection : any_hit);
  round = messages + cost.trace_call + cost.blend_fixed + (header.checkpoint ? cost.evict_move_fixed : 0) +
          (header.tracing == traces::Tracing::closest ? cost.call(1) : 0);
  ray = messages + cost.raygen_prologue + cost.epilogue;
}

namespace {

/// Step lengths by kind and detail of an event: a table, because branches on the kind would be mispredicted.
class StepLengths {
 public:
  explicit StepLengths(const ChainLatencies& latencies) {
    steps_.fill(latencies.stack);
    const auto set = [&](EventKind kind, unsigned detail, Cycle length) { steps_[index(kind, detail)] = length; };
    for (unsigned detail = 0; detail < kDetails; ++detail) {
      set(EventKind::visit_internal, detail, latencies.internal);
      set(EventKind::visit_instance, detail, latencies.instance);
      const bool shader = traces::calls_any_hit(static_cast<traces::LeafOutcome>(detail));
      set(EventKind::visit_leaf, detail, latencies.leaf + (shader ? latencies.any_hit : 0));
    }
  }
  Cycle length_of(const traces::Event& event) const { return steps_[index(event.kind(), event.detail % kDetails)]; }

 private:
  using EventKind = traces::EventKind;
  static constexpr unsigned kDetails = 8;
  static std::size_t index(EventKind kind, unsigned detail) {
    return static_cast<std::size_t>(kind) * kDetails + detail;
  }
  std::array<Cycle, 16 * kDetails> steps_;
};

Chain measure_walk(const traces::RayGroup& group, const ChainLatencies& latencies) {
  Chain chain{0, latencies.ray};
  std::vector<Cycle> lane_cycles(group.rays.size(), latencies.ray);
  std::vector<std::size_t> first_event(group.rays.size());
  for (std::size_t round = 0;; ++round) {
    const auto has_round = [round](const traces::Ray& ray) { return round < ray.rounds.size(); };
    if (std::none_of(group.rays.begin(), group.rays.end(), has_round)) break;
    const WalkCall call = latencies.walk->measure(group, round, first_event);
    chain.warp += latencies.round + call.warp;
    for (std::size_t lane = 0; lane < group.rays.size(); ++lane) {
      if (!has_round(group.rays[lane])) continue;
      lane_cycles[lane] += latencies.round + call.lanes[lane];
      first_event[lane] += group.rays[lane].rounds[round].event_count;
    }
  }
  for (const Cycle cycles : lane_cycles) chain.ray = std::max(chain.ray, cycles);
  return chain;
}

}  // namespace

Chain measure_chain(const traces::RayGroup& group, const ChainLatencies& latencies) {
  if (latencies.walk) return measure_walk(group, latencies);
  Chain chain;
  const StepLengths steps(latencies);
  std::vector<Cycle> rounds;  // longest lane of each round
  for (const traces::Ray& ray : group.rays) {
    Cycle total = latencies.ray;
    const traces::Event* event = ray.events.data();
    for (std::size_t r = 0; r < ray.rounds.size(); ++r) {
      Cycle length = latencies.round;
      for (std::uint32_t i = 0; i < ray.rounds[r].event_count; ++i, ++event) {
        length += steps.length_of(*event);
      }
      total += length;
      if (r == rounds.size()) rounds.push_back(0);
      rounds[r] = std::max(rounds[r], length);
    }
    chain.ray = std::max(chain.ray, total);
  }
  chain.warp = latencies.ray;
  for (const Cycle round : rounds) chain.warp += round;
  return chain;
}

}  // namespace grtx::sim
