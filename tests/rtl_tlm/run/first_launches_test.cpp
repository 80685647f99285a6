// Which SM gets which of the first groups is cycle mode's choice in fast mode too.
#include "grtx/rtl_tlm/run/first_launches.h"

#include <gtest/gtest.h>

#include <numeric>
#include <string>
#include <vector>

#include "grtx/rtl_tlm/config/config_file.h"
#include "grtx/rtl_tlm/estimate/fast/fast_gpu.h"
#include "grtx/rtl_tlm/run/trace_source.h"
#include "paths.h"
#include "rtl_tlm/observe/observed_run.h"
#include "rtl_tlm/simulate_priced.h"

namespace grtx::sim {
namespace {

constexpr Cycle kFirst = 6000;  // cycles, as first_launches.h says

class Launches final : public modules::WarpObserver {
 public:
  void launched(unsigned sm, unsigned /*slot*/, const traces::RayGroup& group, Cycle now) override {
    list.push_back({group.index, sm, now});
  }
  void ended(unsigned /*sm*/, unsigned /*slot*/, Cycle /*now*/) override {}
  nlohmann::json list = nlohmann::json::array();
};

class FirstLaunches : public ::testing::Test {
 protected:
  // Two of three groups meet nothing and end at once.
  FirstLaunches() {
    traces::testing::RandomOptions random{.seed = 5, .groups = 24, .warp_size = 32};
    auto trace = traces::testing::random_trace(random);
    for (std::size_t i = 0; i < trace.groups.size(); ++i) {
      traces::RayGroup& group = trace.groups[i];
      group.kind = traces::RayKind::primary;
      if (i % 3 == 1) continue;
      group.nodes.clear();
      for (traces::Ray& ray : group.rays) {
        ray.rounds.clear();
        ray.events.clear();
        ray.processed.clear();
      }
    }
    traces::testing::write_trace(trace_.path(), trace.header, trace.groups);
  }
  static GpuConfig config() {
    // Eight warp slots for 24 groups.
    return load_config(grtx::paths::source_dir() + "/configs/small.toml", {"gpu.sms=4", "gpu.resident_warps=2"});
  }
  /// All launches of a whole run: group, SM, cycle.
  nlohmann::json launches(SimulationMode mode) const {
    ChildProcess child("launches", [&] {
      Launches seen;
      SimulationOptions options;
      options.observer = &seen;
      test::simulate_priced(trace_.path(), config(), options, mode);
      return seen.list.dump();
    });
    return nlohmann::json::parse(child.result());
  }
  traces::testing::TemporaryFile trace_{"first_launches"};
};

TEST_F(FirstLaunches, AreThoseOfCycleMode) {
  const traces::Reader reader(trace_.path());
  std::vector<std::uint64_t> groups(reader.group_count());
  std::iota(groups.begin(), groups.end(), std::uint64_t{0});
  const std::vector<Launch> first = first_launches(reader, groups, config());
  const nlohmann::json cycle = launches(SimulationMode::cycle);
  ASSERT_EQ(cycle.size(), groups.size());
  EXPECT_GT(first.size(), 8U) << "nothing ended in the first cycles: this test shows nothing";
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].sm, cycle[i][1].get<unsigned>()) << "launch " << i;
    EXPECT_EQ(first[i].cycle, cycle[i][2].get<Cycle>()) << "launch " << i;
  }
  if (first.size() < groups.size()) {
    EXPECT_GE(cycle[first.size()][2].get<Cycle>(), kFirst);
  }
}

// SMs that fast mode would not choose by itself: it takes them in turn.
TEST_F(FirstLaunches, AreFollowedByFastMode) {
  const std::vector<unsigned> wanted = {3, 3, 2, 2, 1, 1, 0, 0, 3};
  ChildProcess child("fast", [&] {
    const traces::Reader reader(trace_.path());
    modules::set_time_resolution_to_fs();
    TraceSource source(reader, 4);
    Launches seen;
    FastGpu gpu(config(), reader.header(), reader.totals().max_evictions_per_ray, source, 1);
    gpu.observe(&seen);
    gpu.assign(wanted);
    gpu.run([](std::uint64_t) {});
    return seen.list.dump();
  });
  const nlohmann::json fast = nlohmann::json::parse(child.result());
  ASSERT_EQ(fast.size(), 24U);
  for (std::size_t i = 0; i < wanted.size(); ++i) EXPECT_EQ(fast[i][1].get<unsigned>(), wanted[i]) << "launch " << i;
}

TEST_F(FirstLaunches, OfARunInFastModeAreThoseOfCycleMode) {
  const nlohmann::json cycle = launches(SimulationMode::cycle);
  const nlohmann::json fast = launches(SimulationMode::fast);
  ASSERT_EQ(fast.size(), cycle.size());
  std::size_t compared = 0;
  for (; compared < cycle.size() && cycle[compared][2].get<Cycle>() < kFirst; ++compared) {
    EXPECT_EQ(fast[compared][0], cycle[compared][0]) << "launch " << compared;
    EXPECT_EQ(fast[compared][1], cycle[compared][1]) << "launch " << compared;
  }
  EXPECT_GT(compared, 8U);
}

}  // namespace
}  // namespace grtx::sim
