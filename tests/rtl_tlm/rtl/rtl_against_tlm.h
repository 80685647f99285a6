// SPDX-License-Identifier: Apache-2.0
// One random trace and configuration on two RT units that differ in one of their units: SystemC, and RTL. The tests run
// some of them, bench/rtl_random.sh many.
#pragma once

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "grtx/rtl_tlm/rtl/rtl_units.h"
#include "rtl_tlm/rt_unit/rt_bench.h"
#include "traces/random_group.h"

namespace grtx::sim::test {

enum class RtlUnit { checkpoint, box, transform };

/// Puts the RTL of a unit in the SystemC unit's place.
inline void use_rtl(RtlUnit unit, modules::RtUnitParts& parts, const RtlBenchOptions& options) {
  switch (unit) {
    case RtlUnit::checkpoint:
      parts.checkpoint_unit = [options](const char* name, const modules::RtUnitContext& rt) {
        return make_checkpoint_rtl(name, rt, options);
      };
      return;
    case RtlUnit::box:
      parts.ray_box = [options](const char* name, const modules::RtUnitContext& rt) {
        return make_box_rtl(name, rt, options);
      };
      return;
    case RtlUnit::transform:
      parts.ray_transform = [options](const char* name, const modules::RtUnitContext& rt) {
        return make_transform_rtl(name, rt, options);
      };
  }
}

/// All that a bench has seen of its RT unit, and the statistics.
struct Seen {
  std::string statistics;
  modules::RtUnitCounters counters;
  std::vector<std::tuple<Cycle, unsigned, unsigned>> dones;                ///< cycle, slot, round
  std::vector<std::tuple<Cycle, unsigned, LaneMask>> batches;              ///< cycle, slot, lanes
  std::vector<std::tuple<unsigned, Cycle, std::uint64_t, bool>> requests;  ///< client, cycle, address, write
};

inline Seen seen(const traces::Header& header, const std::vector<traces::RayGroup>& groups, BenchOptions options) {
  options.resident_warps = std::max<std::size_t>(options.resident_warps, groups.size());
  RtBench bench(header, options);
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const bool any = std::any_of(groups[g].rays.begin(), groups[g].rays.end(),
                                 [](const traces::Ray& ray) { return !ray.rounds.empty(); });
    if (any) bench.launch(groups[g], static_cast<std::uint16_t>(g));
  }
  bench.run(50'000'000);
  Seen all;
  all.statistics = bench.statistics();
  all.counters = bench.counters();
  for (const auto& d : bench.dones) all.dones.emplace_back(d.cycle, d.slot, d.round);
  for (const auto& b : bench.batches) all.batches.emplace_back(b.cycle, b.batch.slot, b.batch.lanes);
  for (unsigned c = 0; c < 4; ++c) {
    for (const auto& r : bench.requests[c]) {
      all.requests.emplace_back(c, r.cycle, r.request.address, bool{r.request.write});
    }
  }
  return all;
}

/// Returns what the RT unit did.
inline modules::RtUnitCounters expect_rtl_agrees(RtlUnit unit, const traces::Header& header,
                                                 const std::vector<traces::RayGroup>& groups, BenchOptions options,
                                                 std::uint64_t disturbance) {
  const Seen tlm = seen(header, groups, options);
  RtlBenchOptions bench{.disturbance = disturbance};
  use_rtl(unit, options.parts, bench);
  const Seen rtl = seen(header, groups, options);
  EXPECT_EQ(tlm.statistics, rtl.statistics);
  EXPECT_EQ(tlm.dones, rtl.dones);
  EXPECT_EQ(tlm.batches, rtl.batches);
  EXPECT_TRUE(tlm.requests == rtl.requests) << "memory requests differ";
  return rtl.counters;
}

/// Number `seed` of the random traces and configurations; every second one with disturbances at the pins.
inline modules::RtUnitCounters expect_rtl_agrees(RtlUnit of, unsigned seed) {
  std::mt19937 random(seed * 7919 + 1);
  const auto pick = [&](unsigned most) { return std::uniform_int_distribution<unsigned>(0, most)(random); };
  const auto one_of = [&](std::initializer_list<unsigned> values) {
    return *(values.begin() + pick(static_cast<unsigned>(values.size()) - 1));
  };
  traces::testing::RandomOptions trace{
      .seed = seed + 1, .groups = 1 + pick(5), .warp_size = one_of({8, 8, 32}), .bvh_width = 2 + pick(4)};
  trace.depth = trace.warp_size == 32 ? 2 : 3;
  trace.k = 1 + pick(3);
  trace.capacity = pick(3) == 0 ? 6 : 1000;
  trace.two_level = of == RtlUnit::transform || pick(1) != 0;
  BenchOptions options;
  options.memory_latency = one_of({2, 3, 20, 117});
  modules::RtUnitConfig& rt = options.rt;
  rt.warp_buffer.entries = one_of({1, 2, 8, 32});
  for (auto* unit : {&rt.ray_box, &rt.ray_triangle, &rt.ray_transform}) {
    *unit = {one_of({1, 4, 32}), one_of({1, 4, 13}), one_of({1, 2})};
  }
  if (of == RtlUnit::box || of == RtlUnit::transform) {
    rt.ray_box = {one_of({1, 2, 4, 8}), one_of({1, 5, 12, 13, 14, 34, 40, 64}), one_of({1, 1, 2, 7, 40})};
    rt.ray_transform = {one_of({1, 2, 4, 8}), one_of({1, 3, 5, 6, 7, 20, 45, 50, 64}), one_of({1, 1, 2, 7, 40})};
    rt.box_op_per_child = pick(3) == 0;
  }
  rt.checkpoint.lanes = one_of({1, 2, 3, 4, 8, 32});
  rt.checkpoint.write_queue = one_of({2, 3, 7, 16, 64});
  rt.checkpoint.write_combine = pick(1) != 0;
  rt.checkpoint.read_buffer = pick(1) != 0;
  rt.checkpoint.entry_bytes = one_of({8, 16, 20, 28});
  rt.sibling_prefetch = pick(1) != 0;
  rt.warp_buffer.spill = pick(3) == 0;
  rt.warp_buffer.stack_entries = 4;
  SCOPED_TRACE(traces::testing::describe(trace));
  const auto made = traces::testing::random_trace(trace);
  return expect_rtl_agrees(of, made.header, made.groups, options, seed % 2 == 0 ? 0 : seed);
}

}  // namespace grtx::sim::test
