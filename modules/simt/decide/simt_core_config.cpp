// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/simt/decide/simt_core_config.h"

#include <numeric>

namespace grtx::modules {

std::uint64_t SimtCounters::all_instructions() const {
  return std::accumulate(instructions.begin(), instructions.end(), std::uint64_t{0});
}

std::uint64_t SimtCounters::resident_warp_cycles() const {
  return std::accumulate(warp_cycles.begin(), warp_cycles.end(), std::uint64_t{0});
}

namespace {

auto of_shader(auto field) {
  return [field](auto& c) -> auto& { return c.shader.*field; };
}

void count_work(CounterTable<SimtCounters>& table) {
  using C = SimtCounters;
  using S = ShaderCounters;
  table.exact(&C::warps, "warps", "warps", "warps (ray groups) that ran to their end")
      .exact(of_shader(&S::warp_rounds), "rounds", "rounds", "traceRay calls of warps")
      .exact(of_shader(&S::ray_rounds), "ray_rounds", "rounds", "rounds of rays executed")
      .sum(of_shader(&S::any_hit_batches), "any_hit.batches", "batches", "any-hit shader invocations of warps")
      .sum(of_shader(&S::any_hit_calls), "any_hit.calls", "calls", "any-hit shader calls of lanes")
      .exact(of_shader(&S::evictions), "evictions", "entries", "entries the any-hit shader wrote to eviction buffers")
      .sum(of_shader(&S::eviction_moves), "eviction_moves", "entries",
           "entries moved from eviction buffers to k-buffers")
      .exact(of_shader(&S::entries_processed), "processed", "entries", "k-buffer entries processed for blending")
      .exact(of_shader(&S::entries_blended), "blended", "entries", "k-buffer entries blended")
      .sum(of_shader(&S::k_buffer_mismatches), "k_buffer_mismatches", "rounds",
           "ray rounds whose any-hit calls do not add up to the k-buffer of the trace; 0 in a correct run");
}

void count_time(CounterTable<SimtCounters>& table) {
  using C = SimtCounters;
  using Phases = CounterColumn<decltype(&C::phases)>;
  const auto of_every_trace = [](PhaseKind kind) { return kind != PhaseKind::intersection; };
  table
      .value(&C::all_instructions, "instructions.total", "instructions", "warp instructions issued",
             StatisticKind::count)
      .by_name<PhaseKind>(of_every_trace,
                          Phases{&C::instructions, "instructions", "instructions", "warp instructions of phase {}"})
      .by_name<PhaseKind>(of_every_trace, Phases{&C::phases, "phases", "phases", "executions of phase {}"})
      .sum(&C::issue_busy_cycles, "issue.busy_cycles", "cycles", "issue slots used, summed over warp schedulers")
      .sum(&C::issue_wait_cycles, "issue.wait_cycles", "cycles", "cycles that phases waited for their warp scheduler")
      .value(&C::resident_warp_cycles, "resident_warp_cycles", "cycles", "resident warps summed over cycles",
             StatisticKind::count)
      .by_name<WarpActivity>(&C::warp_cycles, "warp_cycles", "cycles",
                             "resident warps in state {}, summed over cycles");
}

void count_loads_and_stores(CounterTable<SimtCounters>& table) {
  using S = ShaderCounters;
  using M = LoadStoreCounters;
  const auto of_memory = [](auto field) {
    return [field](auto& c) -> auto& { return c.memory.*field; };
  };
  const auto loads_shader_reads = [](Region region) {  // all others are the RT unit's traffic
    return !is_node(region) && region != Region::checkpoint && region != Region::stack;
  };
  using Column = CounterColumn<decltype(of_memory(&M::loads))>;
  table
      .value([](const SimtCounters& c) { return c.memory.sectors(); }, "lsu.sectors", "sectors",
             "32 B sector requests sent to the L1", StatisticKind::count)
      .by_name<Region>(loads_shader_reads,
                       Column{of_memory(&M::loads), "lsu.loads", "sectors", "sectors loaded from region {}"},
                       Column{of_memory(&M::stores), "lsu.stores", "sectors", "sectors stored to region {}"})
      .sum(of_shader(&S::load_instructions), "lsu.load_instructions", "instructions", "warp load instructions")
      .sum(of_shader(&S::store_instructions), "lsu.store_instructions", "instructions", "warp store instructions")
      .sum(of_memory(&M::blocked_cycles), "lsu.blocked_cycles", "cycles",
           "cycles in which requests waited and the L1 took none")
      .largest(of_memory(&M::deepest_queue), "lsu.deepest_queue", "sectors",
               "most sectors that waited in one load-store unit");
}

void count_off_by_default(CounterTable<SimtCounters>& table) {
  using C = SimtCounters;
  using S = ShaderCounters;
  constexpr auto kIntersection = static_cast<std::size_t>(PhaseKind::intersection);
  table.when([](const C& c) { return c.shader.intersection_batches != 0; })
      .sum(of_shader(&S::intersection_batches), "intersection.batches", "batches",
           "intersection shader invocations of warps")
      .sum(of_shader(&S::intersection_calls), "intersection.calls", "calls", "intersection shader calls of lanes")
      .value([](const C& c) { return c.instructions[kIntersection]; }, "instructions.intersection", "instructions",
             "warp instructions of phase intersection", StatisticKind::count)
      .value([](const C& c) { return c.phases[kIntersection]; }, "phases.intersection", "phases",
             "executions of phase intersection", StatisticKind::count)
      .when([](const C& c) { return c.shader.heap_cycles != 0; })
      .sum(of_shader(&S::heap_cycles), "heap_cycles", "cycles", "cycles of taking hits out of heaps, summed over lanes")
      .when([](const C& c) { return c.shader.colours_made != 0; })
      .sum(of_shader(&S::colours_made), "colours_made", "colours",
           "with colour = frame: colours that shaders made, on each SM its own");
}

}  // namespace

const CounterTable<SimtCounters>& SimtCounters::table() {
  static const CounterTable<SimtCounters> table = [] {
    CounterTable<SimtCounters> all;
    count_work(all);
    count_time(all);
    count_loads_and_stores(all);
    all.own_counts(&SimtCounters::own);
    count_off_by_default(all);
    return all;
  }();
  return table;
}

void describe(const SimtCounters& c, StatisticList& list, const std::string& prefix) {
  SimtCounters::table().describe(c, list, prefix);
}

}  // namespace grtx::modules
