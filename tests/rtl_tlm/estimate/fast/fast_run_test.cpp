// Fast mode against cycle mode, on random traces: close in cycles, and in what the caches saw.
#include <gtest/gtest.h>

#include <numeric>

#include "grtx/base/child_process.h"
#include "grtx/base/error.h"
#include "grtx/rtl_tlm/run/simulation.h"
#include "paths.h"
#include "rtl_tlm/estimate/fast/fast_counters.h"
#include "rtl_tlm/simulate_priced.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;
using traces::testing::RandomOptions;
using traces::testing::TemporaryFile;

class FastRunTest : public ::testing::TestWithParam<bool> {
 protected:
  explicit FastRunTest(bool checkpoint = GetParam()) {
    RandomOptions random{.seed = 3, .groups = 288, .warp_size = 8, .depth = 4, .checkpoint = checkpoint};
    auto trace = traces::testing::random_trace(random);
    traces::testing::write_trace(file_.path(), trace.header, trace.groups);
  }
  ordered_json cycle_mode() const {
    ChildProcess child("cycle",
                       [this] { return test::simulate_priced(file_.path(), config_, {}).document.at("stats").dump(); });
    return ordered_json::parse(child.result());
  }
  GpuCounters whole(const traces::Reader& reader) const {
    std::vector<std::uint64_t> groups(reader.group_count());
    std::iota(groups.begin(), groups.end(), std::uint64_t{0});
    return test::fast_counters(reader, groups, first_launches(reader, groups, config_), config_);
  }

  TemporaryFile file_{"fast"};
  GpuConfig config_ = load_config(grtx::paths::source_dir() + "/configs/small.toml", {});
};

TEST_P(FastRunTest, IsCloseToCycleMode) {
  const ordered_json stats = cycle_mode();
  const auto value = [&stats](const char* name) { return stats.at(name).at("value").get<double>(); };
  const traces::Reader reader(file_.path());
  const GpuCounters run = whole(reader);
  // These warps are short: some latencies that the model leaves out count more than in a scene.
  EXPECT_NEAR(static_cast<double>(run.cycles) / value("gpu.cycles"), 1.0, 0.06);
  EXPECT_NEAR(static_cast<double>(run.l2.accesses()) / value("gpu.l2.accesses"), 1.0, 0.06);
  EXPECT_NEAR(static_cast<double>(run.memory.traffic.bytes) / value("gpu.dram.bytes"), 1.0, 0.06);
  EXPECT_NEAR(static_cast<double>(run.l1.all().reads) / value("gpu.l1.all.reads"), 1.0, 0.01);
}

/// Cycles that a node waits for the L1, of the archived grtx trace on one SM.
double node_latency(SimulationMode mode, const std::vector<std::string>& changes) {
  std::vector<std::string> sets{"gpu.sms=1", "gpu.resident_warps=8", "rt.warp_buffer.entries=8"};
  sets.insert(sets.end(), changes.begin(), changes.end());
  const GpuConfig config = load_config(grtx::paths::source_dir() + "/configs/small.toml", sets);
  ChildProcess child("latency", [&] {
    const std::string trace = grtx::paths::source_dir() + "/data/traces/grtx.grtx";
    return test::simulate_priced(trace, config, {}, mode).document.at("stats").dump();
  });
  return ordered_json::parse(child.result()).at("gpu.rt.node_fetch_latency").at("value").get<double>();
}

// Nodes took places in the miss queue for all sectors of a line in one turn: before a narrow way to the L2 they were
// there 14 % early.
TEST(FastRunTurns, SectorsOfANodeHaveATurnEachWherePlacesAreShort) {
  const std::vector<std::string> narrow{"l1.miss_queue=32", "l1.mshr_entries=1024", "crossbar.link_capacity=1",
                                        "l2.perfect=true"};
  const double expected = node_latency(SimulationMode::cycle, narrow);
  EXPECT_NEAR(node_latency(SimulationMode::fast, narrow), expected, 0.05 * expected);
}

// A port of four sectors took those of one line a cycle, so a node of six sectors had two cycles: it waited 64 % too
// long.
TEST(FastRunTurns, AWidePortTakesSectorsOfSeveralLinesACycle) {
  const std::vector<std::string> wide{"rt.memory.sectors_per_cycle=4", "l1.perfect=true", "l1.banks=64"};
  const double expected = node_latency(SimulationMode::cycle, wide);
  EXPECT_NEAR(node_latency(SimulationMode::fast, wide), expected, 0.05 * expected);
}

/// Which groups were launched where, and when the last one ended.
struct Watch final : modules::WarpObserver {
  std::vector<std::pair<std::uint32_t, unsigned>> launches;
  std::size_t ends = 0;
  Cycle last = 0;
  void launched(unsigned sm, unsigned /*slot*/, const traces::RayGroup& group, Cycle /*now*/) override {
    launches.emplace_back(group.index, sm);
  }
  void ended(unsigned /*sm*/, unsigned /*slot*/, Cycle now) override {
    ++ends;
    last = std::max(last, now);
  }
};

TEST_P(FastRunTest, EveryGroupEndsOnceAndTheSameEachTime) {
  const traces::Reader reader(file_.path());
  const std::vector<std::uint64_t> groups = {3, 7, 8, 40, 95};
  Watch first, again;
  const GpuCounters run = test::fast_counters(reader, groups, {{1, 0}, {1, 1}}, config_, &first);
  ASSERT_EQ(first.launches.size(), groups.size());
  for (std::size_t i = 0; i < groups.size(); ++i) EXPECT_EQ(first.launches[i].first, groups[i]);
  EXPECT_EQ(first.launches[0].second, 1U);
  EXPECT_EQ(first.launches[1].second, 1U);
  EXPECT_EQ(first.ends, groups.size());
  EXPECT_EQ(run.cycles, first.last);
  test::fast_counters(reader, groups, {{1, 0}, {1, 1}}, config_, &again);
  EXPECT_EQ(first.launches, again.launches);
  EXPECT_EQ(first.last, again.last);
}

// A unit that hands over one entry a cycle, to a queue of two: eight lanes wait for it at once.
TEST_P(FastRunTest, CyclesInWhichLanesAreBlockedAreThoseOfTheUnit) {
  config_ = load_config(grtx::paths::source_dir() + "/configs/small.toml",
                        {"rt.checkpoint.lanes=1", "rt.checkpoint.write_queue=2"});
  const traces::Reader reader(file_.path());
  const GpuCounters run = whole(reader);
  const std::uint64_t blocked = run.rt.checkpoint.blocked_cycles;
  EXPECT_LE(blocked, run.cycles * config_.sms);
  EXPECT_EQ(blocked > 0, GetParam());
  const auto in_cycle_mode = cycle_mode().at("gpu.rt.checkpoint.blocked_cycles").at("value").get<double>();
  EXPECT_LE(static_cast<double>(blocked), 1.5 * in_cycle_mode);
  EXPECT_GE(static_cast<double>(blocked), 0.5 * in_cycle_mode);
}

TEST_P(FastRunTest, PerfectCachesAskNobody) {
  const traces::Reader reader(file_.path());
  // A DRAM that counts: with the present one, which warp is the last matters more.
  config_ = load_config(grtx::paths::source_dir() + "/configs/small.toml", {"dram.fixed_latency=2000"});
  const Cycle with = whole(reader).cycles;
  config_.l2.perfect = true;
  const GpuCounters no_dram = whole(reader);
  EXPECT_EQ(no_dram.memory.traffic.responses, 0U);
  EXPECT_GT(no_dram.l2.accesses(), 0U);
  EXPECT_LT(no_dram.cycles, with);
  config_.l1.perfect = true;
  const GpuCounters no_l2 = whole(reader);
  EXPECT_EQ(no_l2.l2.accesses(), 0U);
  EXPECT_LT(no_l2.cycles, no_dram.cycles);
}

// The decoder lets such a trace pass; so do the hashes of a file that was written so.
TEST(FastRunInput, ReplaysWithoutCheckpointsAreRefused) {
  RandomOptions random{.seed = 3, .groups = 96, .warp_size = 8, .depth = 4, .checkpoint = true};
  auto trace = traces::testing::random_trace(random);
  std::size_t replays = 0;
  for (const auto& group : trace.groups) {
    for (const auto& ray : group.rays) {
      for (const auto& round : ray.rounds) replays += round.replay ? 1 : 0;
    }
  }
  ASSERT_GT(replays, 0U);
  trace.header.checkpoint = false;
  trace.header.checkpoint_capacity = 0;
  const TemporaryFile file{"fast"};
  traces::testing::write_trace(file.path(), trace.header, trace.groups);
  const traces::Reader reader(file.path());
  EXPECT_THAT([&] { test::fast_counters(reader, load_config(grtx::paths::source_dir() + "/configs/small.toml", {})); },
              ::testing::ThrowsMessage<Error>(::testing::HasSubstr("although checkpointing is off")));
}

INSTANTIATE_TEST_SUITE_P(Checkpointing, FastRunTest, ::testing::Bool(),
                         [](const auto& i) { return i.param ? "on" : "off"; });

}  // namespace
}  // namespace grtx::sim
