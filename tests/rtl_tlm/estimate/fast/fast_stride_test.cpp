// Fast mode in which one in so many of a lane's events takes time: nothing of the trace is lost, the laws hold, the
// caches see what they would see, and cycles are estimated.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/rtl_tlm/estimate/fast/fast_gpu.h"
#include "grtx/rtl_tlm/estimate/fast/timed_share.h"
#include "paths.h"
#include "rtl_tlm/estimate/fast/fast_counters.h"
#include "rtl_tlm/observe/observed_run.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

using test::statistic;
using traces::testing::RandomOptions;
using traces::testing::TemporaryFile;

std::string stride(unsigned events) { return "fast.stride=" + std::to_string(events); }

struct Machine {
  const char* name;
  bool checkpoint;
  std::vector<std::string> settings;
  friend void PrintTo(const Machine& c, std::ostream* out) { *out << c.name; }
};

class FastStride : public ::testing::TestWithParam<Machine> {
 protected:
  nlohmann::ordered_json run(unsigned events, const std::string& more = "fast.seed=1") const {
    std::vector<std::string> settings = GetParam().settings;
    settings.push_back(stride(events));
    settings.push_back(more);
    return run_.run({}, settings, SimulationMode::fast);  // fails when a conservation law does not hold
  }
  test::ObservedRun run_{GetParam().checkpoint, GetParam().checkpoint};
};

TEST_P(FastStride, CountsAllThatTheTraceGives) {
  const auto all = run(1);
  for (const unsigned events : {2U, 8U, 64U}) {
    const auto share = run(events);
    for (const char* exact :
         {"gpu.rt.node_visits", "gpu.rt.visits_internal", "gpu.rt.visits_instance", "gpu.rt.visits_leaf",
          "gpu.rt.culls", "gpu.rt.any_hit_calls", "gpu.rt.calls", "gpu.rt.max_stack_depth", "gpu.rt.stack.max_spilled",
          "gpu.simt.warps", "gpu.simt.rounds", "gpu.simt.any_hit.calls", "gpu.simt.evictions",
          "gpu.simt.eviction_moves", "gpu.simt.processed", "gpu.simt.blended", "gpu.simt.instructions.blend",
          "gpu.simt.phases.evict_move"}) {
      EXPECT_EQ(statistic(share, exact), statistic(all, exact)) << exact << ", one in " << events;
    }
    EXPECT_EQ(statistic(share, "gpu.fast.stride"), events);
    if (GetParam().checkpoint) {
      for (const char* exact :
           {"gpu.rt.checkpoint.entries_written", "gpu.rt.checkpoint.entries_read", "gpu.rt.checkpoint.max_entries"}) {
        EXPECT_EQ(statistic(share, exact), statistic(all, exact)) << exact << ", one in " << events;
      }
    }
  }
}

TEST_P(FastStride, GivesTheSameEachTime) {
  const auto first = run(4), again = run(4);
  for (const auto& [name, entry] : first.items()) {
    if (name.starts_with("host.")) continue;
    EXPECT_EQ(entry, again.at(name)) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Machines, FastStride,
    ::testing::Values(
        Machine{"baseline", false, {}}, Machine{"grtx", true, {}}, Machine{"perfect_l1", true, {"l1.perfect=true"}},
        Machine{"two_mshrs", true, {"l1.mshr_entries=2"}}, Machine{"no_prefetch", true, {"rt.prefetch.enabled=false"}},
        Machine{"no_merging", false, {"rt.memory.merge_in_flight=false"}},
        Machine{"spilling", true, {"rt.warp_buffer.stack_entries=2"}},
        Machine{
            "private_stores", true, {"simt.private_store.k_buffer_entries=4", "simt.private_store.eviction_entries=2"}},
        Machine{"write_combining", true, {"rt.checkpoint.write_combine=true", "rt.checkpoint.read_buffer=true"}}),
    [](const auto& i) { return std::string(i.param.name); });

class FastStrideTrace : public ::testing::TestWithParam<bool> {
 protected:
  FastStrideTrace() {
    RandomOptions random{.seed = 5, .groups = 96, .warp_size = 16, .depth = 6, .checkpoint = GetParam()};
    const auto trace = traces::testing::random_trace(random);
    traces::testing::write_trace(file_.path(), trace.header, trace.groups);
  }
  GpuCounters run(std::vector<std::string> settings) const {
    const traces::Reader reader(file_.path());
    return test::fast_counters(reader, load_config(grtx::paths::source_dir() + "/configs/small.toml", settings));
  }
  TemporaryFile file_{"fast"};
};

TEST_P(FastStrideTrace, EstimatesCyclesAndTraffic) {
  using Value = std::function<std::uint64_t(const GpuCounters&)>;
  constexpr auto kAnyHit = static_cast<std::size_t>(modules::PhaseKind::any_hit);
  constexpr auto kMemory = static_cast<std::size_t>(modules::WarpActivity::memory);
  constexpr auto kBlend = static_cast<std::size_t>(modules::WarpActivity::blend);
  const std::vector<std::pair<std::string, Value>> values = {
      {"cycles", [](const GpuCounters& c) { return c.cycles; }},
      {"lanes handled", [](const GpuCounters& c) { return c.rt.scheduler.lanes_handled; }},
      {"fetches", [](const GpuCounters& c) { return c.rt.memory.node_fetches(); }},
      {"selections", [](const GpuCounters& c) { return c.rt.scheduler.selections; }},
      {"occupancy", [](const GpuCounters& c) { return c.rt.warp_buffer.occupancy_integral; }},
      {"warp latency", [](const GpuCounters& c) { return c.rt.warp_buffer.warp_latency.sum(); }},
      {"L1 accesses", [](const GpuCounters& c) { return c.l1.accesses(); }},
      {"any-hit instructions", [](const GpuCounters& c) { return c.simt.instructions[kAnyHit]; }},
      {"waits for loads", [](const GpuCounters& c) { return c.simt.warp_cycles[kMemory]; }},
      {"blending", [](const GpuCounters& c) { return c.simt.warp_cycles[kBlend]; }}};
  const GpuCounters all = run({stride(1)});
  constexpr unsigned kSeeds = 8;
  std::vector<GpuCounters> draws;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) draws.push_back(run({stride(4), fmt::format("fast.seed={}", seed)}));
  for (const auto& [name, value] : values) {
    double sum = 0.0;
    std::set<std::uint64_t> different;
    for (const GpuCounters& draw : draws) {
      sum += static_cast<double>(value(draw));
      different.insert(value(draw));
    }
    const auto expected = static_cast<double>(value(all));
    // Any-hit shaders that run at the same time slow each other's chains of loads down; those of other events do not
    // run.
    const double tolerance = name == "waits for loads" ? 0.16 : 0.08;
    EXPECT_NEAR(sum / kSeeds, expected, tolerance * expected) << name;
    EXPECT_GT(different.size(), 1U) << name << ": the seed changes nothing";
  }
}

// Behind a slow DRAM: a quarter of a phase's loads, which wait for each other a quarter as long, were taken to wait a
// quarter of that.
TEST_P(FastStrideTrace, BlendingWaitsForTheLastOfAllItsLoads) {
  constexpr auto kMemory = static_cast<std::size_t>(modules::WarpActivity::memory);
  const traces::Reader reader(grtx::paths::source_dir() + "/data/traces/" + (GetParam() ? "grtx" : "baseline") +
                              ".grtx");
  const auto waits = [&](unsigned events, unsigned seed) {
    // Any-hit shaders, which load the k-buffer, wait for nothing: what is left is blending.
    const GpuConfig config =
        load_config(grtx::paths::source_dir() + "/configs/small.toml",
                    {stride(events), fmt::format("fast.seed={}", seed), "dram.mhz=300",
                     "simt.private_store.k_buffer_entries=16", "simt.private_store.eviction_entries=16"});
    return static_cast<double>(test::fast_counters(reader, config).simt.warp_cycles[kMemory]);
  };
  constexpr unsigned kSeeds = 8;
  double sum = 0.0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) sum += waits(4, seed);
  const double expected = waits(1, 1);
  EXPECT_NEAR(sum / kSeeds, expected, 0.04 * expected);
}

// fast.spread=false is how results before 2026-11-24 were made; with every event there is nothing to spread.
TEST_P(FastStrideTrace, SpreadingIsOfEventsWithoutTime) {
  EXPECT_EQ(run({stride(1), "fast.spread=false"}).cycles, run({stride(1)}).cycles);
  EXPECT_NE(run({stride(8), "fast.spread=false"}).cycles, run({stride(8)}).cycles);
}

// What is written ends in the L2, whoever takes time: with room for all, as many sectors are dirty at the end.
TEST_P(FastStrideTrace, CachesSeeEveryWrite) {
  const auto one_warp = [this](unsigned events) {
    return run({stride(events), "gpu.sms=1", "gpu.resident_warps=1", "l2.bytes=67108864"});
  };
  const GpuCounters all = one_warp(1);
  ASSERT_EQ(all.l2.evictions, 0U);
  ASSERT_GT(all.l2_dirty_sectors, 0U);
  for (const unsigned events : {2U, 16U, 64U}) {
    EXPECT_EQ(one_warp(events).l2_dirty_sectors, all.l2_dirty_sectors) << events;
  }
}

INSTANTIATE_TEST_SUITE_P(Checkpoints, FastStrideTrace, ::testing::Bool(),
                         [](const auto& i) { return std::string(i.param ? "on" : "off"); });

TEST(FastStrideChoice, LeavesEnoughEventsThatTakeTime) {
  GpuConfig config;
  EXPECT_EQ(fast_stride(config, 0), 1U);
  EXPECT_EQ(fast_stride(config, 999999), 1U);
  EXPECT_EQ(fast_stride(config, 1000000), 2U);
  EXPECT_EQ(fast_stride(config, 1999999), 2U);
  EXPECT_EQ(fast_stride(config, 2000000), 4U);
  EXPECT_EQ(fast_stride(config, 1000000000), 4U);
  config.fast.stride = 16;
  EXPECT_EQ(fast_stride(config, 0), 16U);
}

TEST(FastStrideChoice, IsAPowerOfTwo) {
  EXPECT_THAT([&] { load_config("", {"fast.stride=3"}); },
              ::testing::ThrowsMessage<Error>(::testing::HasSubstr("fast.stride")));
}

TEST(TimedShare, KeepsWhatTheTraceGivesAndMultipliesTheRest) {
  modules::RtUnitCounters rt;
  rt.units = 1;
  rt.warp_buffer.calls = 3;
  rt.warp_buffer.occupancy_integral = 10;
  rt.warp_buffer.max_stack_depth = 7;
  rt.warp_buffer.warp_latency.add(5);
  rt.scheduler.visits_leaf = 11;
  rt.scheduler.selections = 12;
  rt.memory.visits[0] = 13;
  rt.memory.fetches[0] = 14;
  rt.memory.fetch_latency.add(100);
  rt.checkpoint.entries_read = 15;
  rt.checkpoint.sectors_read = 16;
  rt.checkpoint.max_entries = 17;
  fast::scale_up(rt, 3);
  EXPECT_EQ(rt.units, 1U);
  EXPECT_EQ(rt.warp_buffer.calls, 3U);
  EXPECT_EQ(rt.warp_buffer.occupancy_integral, 80U);
  EXPECT_EQ(rt.warp_buffer.max_stack_depth, 7U);
  EXPECT_EQ(rt.warp_buffer.warp_latency.count(), 1U);  // as many calls, each eight times as long
  EXPECT_EQ(rt.warp_buffer.warp_latency.sum(), 40U);
  EXPECT_EQ(rt.warp_buffer.warp_latency.max(), 40U);
  EXPECT_EQ(rt.warp_buffer.warp_latency.bin(6), 1U);
  EXPECT_EQ(rt.scheduler.visits_leaf, 11U);
  EXPECT_EQ(rt.scheduler.selections, 96U);
  EXPECT_EQ(rt.memory.visits[0], 13U);
  EXPECT_EQ(rt.memory.fetches[0], 112U);
  EXPECT_EQ(rt.memory.fetch_latency.count(), 8U);  // eight times as many fetches, each as long
  EXPECT_EQ(rt.memory.fetch_latency.max(), 100U);
  EXPECT_EQ(rt.checkpoint.entries_read, 15U);
  EXPECT_EQ(rt.checkpoint.sectors_read, 128U);
  EXPECT_EQ(rt.checkpoint.max_entries, 17U);
}

TEST(TimedShare, OfAnyHitShadersOnlyTheTimedOnesStandForOthers) {
  constexpr auto kAnyHit = static_cast<std::size_t>(modules::PhaseKind::any_hit);
  constexpr auto kBlend = static_cast<std::size_t>(modules::PhaseKind::blend);
  modules::SimtCounters simt;
  simt.warps = 2;
  simt.instructions[kAnyHit] = 30;
  simt.instructions[kBlend] = 40;
  simt.phases[kAnyHit] = 5;
  simt.phases[kBlend] = 6;
  simt.issue_busy_cycles = 7;
  simt.shader.any_hit_batches = 5 + 9;
  simt.shader.any_hit_calls = 21;
  simt.shader.load_instructions = 100 + 20 + 33;  // of other phases, timed and other any-hit shaders
  simt.shader.store_instructions = 50 + 10 + 11;
  simt.shader.intersection_batches = 3 + 4;
  fast::scale_up(simt, 2, {.batches = 5, .intersections = 3, .loads = 20, .stores = 10},
                 {.batches = 9, .intersections = 4, .loads = 33, .stores = 11});
  EXPECT_EQ(simt.warps, 2U);
  EXPECT_EQ(simt.instructions[kAnyHit], 120U);
  EXPECT_EQ(simt.instructions[kBlend], 40U);
  EXPECT_EQ(simt.phases[kAnyHit], 20U);
  EXPECT_EQ(simt.phases[kBlend], 6U);
  EXPECT_EQ(simt.issue_busy_cycles, 28U);
  EXPECT_EQ(simt.shader.any_hit_batches, 20U);
  EXPECT_EQ(simt.shader.intersection_batches, 12U);
  EXPECT_EQ(simt.shader.any_hit_calls, 21U);
  EXPECT_EQ(simt.shader.load_instructions, 100U + 80U);
  EXPECT_EQ(simt.shader.store_instructions, 50U + 40U);
}

}  // namespace
}  // namespace grtx::sim
