// SPDX-License-Identifier: Apache-2.0
// The checkpoint unit in SystemVerilog against the SystemC unit, each in an RT unit of its own on the same trace: every
// statistic, retirement, batch and memory request, to the cycle. The bridge checks bytes and t-value validation by
// itself (rtl_tlm/rtl/checkpoint_rtl.cpp), so each of these runs checks them, too.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstdlib>
#include <string>

#include "error_of.h"
#include "grtx/base/error.h"
#include "grtx/rtl_tlm/rtl/rtl_units.h"
#include "rtl_tlm/rt_unit/rt_bench.h"
#include "rtl_tlm/rtl/rtl_against_tlm.h"

namespace grtx::sim {
namespace {

using namespace test;

class CheckpointRtl : public modules::SystemCTest {
 protected:
  void SetUp() override {
    modules::SystemCTest::SetUp();
    if (!has_rtl()) GTEST_SKIP() << "no Verilator when this was built";
  }
};

// GRTX_RTL_CASES: how many (bench/rtl_random.sh).
TEST_F(CheckpointRtl, AgreesToTheCycleOnRandomTracesAndConfigurations) {
  const char* wanted = std::getenv("GRTX_RTL_CASES");
  const unsigned cases = wanted != nullptr ? static_cast<unsigned>(std::stoul(wanted)) : 48;
  modules::CheckpointCounters sum;
  for (unsigned seed = 0; seed < cases && !HasFailure(); ++seed) {
    sum.add(expect_rtl_agrees(RtlUnit::checkpoint, seed).checkpoint);
  }
  EXPECT_GT(sum.entries_written, 300 * cases);
  EXPECT_GT(sum.entries_read, 100 * cases);
  EXPECT_GT(sum.blocked_cycles, 20 * cases);
  EXPECT_GT(sum.straddling_read, 10 * cases);
  fmt::print("{} cases: {} entries written, {} read, {} sectors written, {} read, {} cycles blocked\n", cases,
             sum.entries_written, sum.entries_read, sum.sectors_written, sum.sectors_read, sum.blocked_cycles);
}

// Replaying, wide submissions, queues of two sectors: what random traces reach rarely.
TEST_F(CheckpointRtl, AgreesOnOneRayWithEveryEntrySize) {
  for (const unsigned bytes : {8u, 16u, 20u, 28u}) {
    for (const bool combine : {false, true}) {
      for (const bool buffer : {false, true}) {
        SCOPED_TRACE(fmt::format("{} B, write_combine {}, read_buffer {}", bytes, combine, buffer));
        std::vector<traces::RayGroup> groups(1);
        traces::RayGroup& group = groups[0];
        group.nodes = {node_definition(1, 10, std::vector<traces::NodeKind>(6, traces::NodeKind::internal))};
        group.rays.resize(32);
        for (unsigned lane = 0; lane < 32; ++lane) {
          const unsigned entries = lane % 12;  // culled at once
          add_round(group.rays[lane], {internal_event(0, 0b1, 0b111110), cull_event(10, entries)});
          std::vector<Event> replay(entries + 5, forward_event(10, 1));
          add_round(group.rays[lane], replay, true);
          add_round(group.rays[lane], replay, true);
        }
        BenchOptions options;
        options.rt.checkpoint.entry_bytes = bytes;
        options.rt.checkpoint.write_combine = combine;
        options.rt.checkpoint.read_buffer = buffer;
        options.rt.checkpoint.write_queue = 2;
        options.rt.sibling_prefetch = false;
        expect_rtl_agrees(RtlUnit::checkpoint, small_header("tri20", 64), groups, options, bytes);
      }
    }
  }
}

struct Fault {
  unsigned number;
  const char* name;
  const char* message;
};

/// What a run with the faulty block says; empty: nothing.
std::string run_with_fault(unsigned fault, const modules::CheckpointConfig& config) {
  std::vector<traces::RayGroup> groups(1);
  groups[0].nodes = {node_definition(1, 10, std::vector<traces::NodeKind>(6, traces::NodeKind::internal))};
  groups[0].rays.resize(1);
  add_round(groups[0].rays[0], {internal_event(0, 0b1, 0b111110), cull_event(10, 1)});
  add_round(groups[0].rays[0], std::vector<Event>(6, forward_event(10, 1)), true);
  BenchOptions options;
  options.rt.checkpoint = config;
  options.rt.sibling_prefetch = false;
  RtlBenchOptions block{.faulty_block = true, .fault = fault};
  use_rtl(RtlUnit::checkpoint, options.parts, block);
  RtBench bench(small_header("tri20", 64), options);
  bench.launch(groups[0], 0);
  try {
    bench.run(5000);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

TEST_F(CheckpointRtl, SeededFaultsAreCaughtWithTheirMessage) {
  for (const bool combine : {false, true}) {
    modules::CheckpointConfig config;
    config.write_combine = combine;
    EXPECT_EQ(run_with_fault(0, config), "") << "the block without its faults";
    EXPECT_THAT(run_with_fault(1, config), ::testing::HasSubstr("rt.checkpoint_unit (RTL): t-value validation"));
    EXPECT_THAT(run_with_fault(2, config),
                ::testing::HasSubstr("rt.checkpoint_unit (RTL): warp 0 lane 0: source entry"));
    EXPECT_THAT(run_with_fault(3, config),
                ::testing::HasSubstr("rt.checkpoint_unit (RTL): warp 0 lane 0: source entry"));
  }
}

TEST_F(CheckpointRtl, RefusesTracesWithBins) {
  traces::Header header = small_header("tri20", 512);
  header.checkpoint_bins = 4;
  BenchOptions options;
  options.rt.checkpoint.entry_bytes = 8;
  use_rtl(RtlUnit::checkpoint, options.parts, {});
  EXPECT_THAT(grtx::test::error_of([&] { RtBench bench(header, options); }),
              ::testing::HasSubstr("checkpoint bins are not in the RTL: needs rt.checkpoint.implementation = tlm"));
}

TEST_F(CheckpointRtl, RefusesWhatItDoesNotHave) {
  const auto refusal = [](void (*change)(modules::RtUnitConfig&)) {
    modules::RtUnitConfig rt;
    change(rt);
    return std::string(checkpoint_rtl_refusal(rt).key);
  };
  EXPECT_EQ(refusal([](auto&) {}), "");
  EXPECT_EQ(refusal([](auto& rt) { rt.checkpoint.lanes = 33; }), "checkpoint.lanes");
  EXPECT_EQ(refusal([](auto& rt) { rt.checkpoint.write_queue = 65; }), "checkpoint.write_queue");
  EXPECT_EQ(refusal([](auto& rt) { rt.warp_buffer.entries = 33; }), "warp_buffer.entries");
}

TEST_F(CheckpointRtl, ABufferThatIsTooSmallIsTheErrorOfTheSystemCUnit) {
  std::string said[2];
  for (const bool rtl : {false, true}) {
    traces::RayGroup group;
    group.nodes = {node_definition(1, 10, std::vector<traces::NodeKind>(6, traces::NodeKind::internal))};
    group.rays.resize(1);
    add_round(group.rays[0], {internal_event(0, 0b1, 0b111110), cull_event(10, 60)});
    BenchOptions options;
    options.rt.sibling_prefetch = false;
    if (rtl) use_rtl(RtlUnit::checkpoint, options.parts, {});
    RtBench bench(small_header("tri20", 64), options);
    bench.launch(group, 0);
    try {
      bench.run_expecting_error();
    } catch (const std::exception& error) {
      said[rtl ? 1 : 0] = error.what();
    }
  }
  EXPECT_THAT(said[0], ::testing::HasSubstr("a ray writes more entries than the header's checkpoint_capacity"));
  EXPECT_EQ(said[0], said[1]);
}

}  // namespace
}  // namespace grtx::sim
