// SPDX-License-Identifier: Apache-2.0
// Lower bounds from counters, with the formula beside each, and the longest dependent chain of a hand-made group.
#include "grtx/rtl_tlm/run/lower_bounds.h"

#include <gtest/gtest.h>

#include <map>

#include "grtx/rtl_tlm/gpu/built_in_memory.h"
#include "grtx/rtl_tlm/run/ray_chain.h"
#include "rtl_tlm/observe/observed_run.h"
#include "rtl_tlm/simulate_priced.h"
#include "rtl_tlm/tiny_trace.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

std::map<std::string, Cycle> bounds_of(const GpuCounters& counters, const Chain& chain, const GpuConfig& config) {
  std::map<std::string, Cycle> result;
  for (const LowerBound& bound : lower_bounds(counters, chain, config)) result[bound.name] = bound.cycles;
  return result;
}

GpuCounters two_sms() {
  GpuCounters c;
  c.rt_of.resize(2);
  c.simt_of.resize(2);
  c.l1_of.resize(2);
  c.l2_of.resize(2);
  return c;
}

TEST(LowerBounds, TakeTheBusiestUnitAndDivideByItsWidth) {
  GpuConfig config;
  GpuCounters c = two_sms();
  c.rt_of[0].scheduler.selections = 10;
  c.rt_of[1].scheduler.selections = 30;
  c.rt_of[1].ray_box.busy_cycles = 401;
  c.rt_of[0].ray_triangle.busy_cycles = 8;
  c.rt_of[0].memory.sectors[0] = 70;
  c.simt_of[0].issue_busy_cycles = 41;
  c.l1_of[1].prefetches = 9;
  c.l1_of[1].sent_reads = 5;
  c.l1_of[1].sent_writes = 6;
  c.l2_of[0].region[0].reads = 12;
  std::vector<modules::DramChannelCounters> channels(2);
  channels[1].bursts = 1002;
  c.memory = built_in_counters(config, channels, {}, channels);
  const auto bounds = bounds_of(c, {500, 600}, config);
  EXPECT_EQ(bounds.at("issue"), 30U);
  EXPECT_EQ(bounds.at("unit.box"), 101U);     // ceil(401 / 4 pipelines)
  EXPECT_EQ(bounds.at("unit.triangle"), 2U);  // 8 / 4
  EXPECT_EQ(bounds.at("rt_port"), 70U);       // one sector per cycle
  EXPECT_EQ(bounds.at("simt_issue"), 11U);    // ceil(41 / 4 schedulers)
  EXPECT_EQ(bounds.at("l1_port"), 3U);        // ceil(9 / 4 banks)
  EXPECT_EQ(bounds.at("l1_miss_port"), 11U);  // 5 + 6
  EXPECT_EQ(bounds.at("l2_port"), 12U);
  EXPECT_EQ(bounds.at("dram_bandwidth"), 1560U);  // (1002 - 2) bursts x 4 clocks x 1365 / 3500
  EXPECT_EQ(bounds.at("longest_ray"), 500U);
  EXPECT_EQ(bounds.at("longest_warp"), 600U);
  EXPECT_EQ(binding_bound(lower_bounds(c, {500, 600}, config)).name, "dram_bandwidth");
}

// Eight heap logics serve all lanes of the RT unit, so a design that keeps hits in heaps may be bound by them.
TEST(LowerBounds, HeapLogicsBindAsPipelinesDo) {
  GpuConfig config;
  config.rt.any_hit_unit.enabled = true;
  config.rt.any_hit_unit.count = 8;
  GpuCounters c = two_sms();
  c.rt_of[0].any_hit.unit = {.hits = 90, .busy_cycles = 700};
  c.rt_of[1].any_hit.unit = {.hits = 80, .busy_cycles = 801};
  EXPECT_EQ(bounds_of(c, {}, config).at("unit.heap"), 101U);  // ceil(801 / 8 logics)
}

// A test takes its pipeline for `interval` cycles, but nothing waits after the last one.
TEST(LowerBounds, APipelineIsNotWaitedForAfterItsLastTest) {
  GpuConfig config;
  config.rt.ray_box = {2, 13, 5};
  config.rt.ray_triangle = {1, 37, 7};
  config.rt.ray_sphere = {4, 37, 3};
  config.rt.ray_gaussian = {3, 9, 4};
  config.rt.ray_transform = {1, 4, 64};
  GpuCounters c = two_sms();
  c.rt_of[0].ray_box.busy_cycles = 7 * 5;
  c.rt_of[1].ray_box.busy_cycles = 6 * 5;
  c.rt_of[1].ray_triangle.busy_cycles = 3 * 7;
  c.rt_of[0].ray_sphere.busy_cycles = 1 * 3;
  c.rt_of[0].ray_gaussian.operations = 8;  // a unit that nobody has is not listed
  c.rt_of[0].ray_gaussian.busy_cycles = 8 * 4;
  c.rt_of[1].ray_transform.busy_cycles = 1 * 64;
  const auto bounds = bounds_of(c, {}, config);
  EXPECT_EQ(bounds.at("unit.box"), 18U - 4U);       // ceil(7 tests x 5 / 2 pipelines) - (5 - 1)
  EXPECT_EQ(bounds.at("unit.triangle"), 21U - 6U);  // 3 tests x 7 in one pipeline: the third starts in cycle 14
  EXPECT_EQ(bounds.at("unit.sphere"), 0U);          // one of four pipelines
  EXPECT_EQ(bounds.at("unit.gaussian"), 11U - 3U);  // ceil(8 x 4 / 3) - 3
  EXPECT_EQ(bounds.at("unit.transform"), 1U);
}

// A run of eight box tests in pipelines that are slower than all else: the bound is near its cycles, and not above.
TEST(LowerBounds, AUnitWithAnIntervalBindsARunAndIsNotAboveIt) {
  const traces::testing::TemporaryFile file("interval");
  test::write_tiny_trace(file.path(), {1, 8});
  const std::vector<std::string> slow = {"rt.box.count=1", "rt.box.interval=3000"};
  const auto stats = test::small_statistics(file.path(), slow);  // breaks no law: no bound is above the cycles
  EXPECT_EQ(stats.at("gpu.rt.ray_box.tests").at("value"), 8U);
  EXPECT_EQ(stats.at("gpu.bound.unit.box").at("value"), 8U * 3000U - 2999U);
  EXPECT_GT(stats.at("gpu.bound.fraction").at("value").get<double>(), 0.9);
  EXPECT_EQ(stats.at("gpu.bound.largest").at("description"), "largest lower bound: unit.box");
}

// The same traffic of each channel, a part of it for each port of the L2.
TEST(LowerBounds, BandwidthOfTheL2IsChosenWithoutThatOfTheDram) {
  const test::ObservedRun run;
  // Nothing is replaced in the L2, and nothing prefetched: what the DRAM reads does not hang on times.
  const std::vector<std::string> few_slices = {"l2.bytes=8388608", "rt.prefetch.enabled=false", "l2.slices=2"};
  std::vector<std::string> many_slices = few_slices;
  many_slices.back() = "l2.slices=8";
  many_slices.emplace_back("dram.channels=2");
  const auto few = run.run({}, few_slices), many = run.run({}, many_slices);
  EXPECT_LT(static_cast<double>(test::statistic(many, "gpu.bound.l2_port")),
            0.6 * static_cast<double>(test::statistic(few, "gpu.bound.l2_port")));
  for (const char* same : {"gpu.bound.dram_bandwidth", "gpu.dram.channel0.bytes", "gpu.dram.channel1.bytes"}) {
    const auto bytes = static_cast<double>(test::statistic(few, same));
    EXPECT_GT(bytes, 0.0) << same;
    EXPECT_NEAR(static_cast<double>(test::statistic(many, same)), bytes, 0.02 * bytes) << same;
  }
  EXPECT_FALSE(many.contains("gpu.dram.channel2.bytes"));
}

// A hit of an L1 that is slower than the L2 takes longer than a miss: a run was called too fast.
TEST(LowerBounds, AMissIsNoSlowerThanTheL2) {
  GpuConfig config;
  config.rt.memory.merge_in_flight = false;
  config.l1.mshr_merges = 1;
  const traces::Header header;
  const Cycle hit = ChainLatencies(config, header).internal;
  config.l1.latency = 3529;
  EXPECT_EQ(ChainLatencies(config, header).internal, hit - 20 + 165);
}

// A ray whose nodes are being prefetched when it comes waits for less than a hit takes: runs were called too fast.
TEST(LowerBounds, AVisitThatJoinsAMissOfTheL1MayBeSoonerThanAHit) {
  GpuConfig config;
  config.rt.memory.merge_in_flight = false;
  const traces::Header header;
  const Cycle joined = ChainLatencies(config, header).internal;
  config.l1.latency = 1000;
  EXPECT_EQ(ChainLatencies(config, header).internal, joined);
  config.l1.mshr_merges = 1;  // nothing joins
  config.l1.latency = 20;
  EXPECT_EQ(ChainLatencies(config, header).internal, joined - 2 + 20);
}

TEST(LowerBounds, PerfectDramHasNoDataBus) {
  GpuConfig config;
  config.dram.perfect = true;
  GpuCounters c = two_sms();
  std::vector<modules::DramChannelCounters> channels(2);
  channels[0].bursts = 1000;
  c.memory = built_in_counters(config, channels, {}, channels);
  EXPECT_EQ(bounds_of(c, {}, config).at("dram_bandwidth"), 0U);
}

TEST(LongestRay, SumsTheVisitsOfATinyRay) {
  GpuConfig config;
  config.rt.memory.merge_in_flight = false;
  config.l1.mshr_merges = 1;
  const test::TinyTrace tiny{1, 2};
  const ChainLatencies latencies(config, test::tiny_header(tiny));
  // Fetch: 1 to the request, 1 link, 20 L1, 1 into the unit; box 13, triangle 37.
  EXPECT_EQ(latencies.internal, 36U);
  EXPECT_EQ(latencies.leaf, 60U);
  // Messages 1 + 1, 12 instructions, result after 4.
  EXPECT_EQ(latencies.any_hit, 18U);
  // Messages 1 + 1, traceRay 6, blending 10; no eviction move without checkpointing.
  EXPECT_EQ(latencies.round, 18U);
  // Messages 1 + 1, prologue 40, epilogue 10.
  EXPECT_EQ(latencies.ray, 52U);
  const Chain chain = measure_chain(test::tiny_group(tiny, 0), latencies);
  EXPECT_EQ(chain.ray, 52U + 18 + 36 + 2 * (60 + 18));
  EXPECT_EQ(chain.warp, chain.ray);

  // A visit that joins a fetch under way may wait for less than an L1 hit: only the box test and its start are certain.
  config.rt.memory.merge_in_flight = true;
  EXPECT_EQ(ChainLatencies(config, test::tiny_header(tiny)).internal, 36U - 22U);
}

TEST(LongestRay, AWarpWaitsForTheLongestLaneOfEachRound) {
  const GpuConfig config;
  const test::TinyTrace tiny{1, 2};
  const ChainLatencies l(config, test::tiny_header(tiny));
  traces::RayGroup group = test::tiny_group(tiny, 0);
  // Lane 0: long round 0, then an empty round; lane 1: short round 0 (one event), then two leaves.
  group.rays[0].rounds.push_back({});
  traces::Ray& lane1 = group.rays[1];
  lane1.rounds[0].event_count = 1;
  lane1.rounds.push_back({});
  lane1.rounds[1].event_count = 2;
  const Chain chain = measure_chain(group, l);
  const Cycle leaf = l.leaf + l.any_hit;
  EXPECT_EQ(chain.ray, l.ray + 2 * l.round + l.internal + 2 * leaf);
  EXPECT_EQ(chain.warp, l.ray + 2 * l.round + (l.internal + 2 * leaf) + 2 * leaf);
}

}  // namespace
}  // namespace grtx::sim
