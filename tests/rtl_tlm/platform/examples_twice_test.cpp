// SPDX-License-Identifier: Apache-2.0
// Parts of the examples, launched twice on a GpuComponent, give the same figures twice. The other examples:
// platform_example_test.cpp, own_unit_test.cpp, own_study_test.cpp (a process for each launch).
#include <gtest/gtest.h>

#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "rtl_tlm/platform/platform_bench.h"
#include "rtl_tlm/tiny_trace.h"
#include "traces/temporary_file.h"

#define sc_main own_dram_main  // the test has one of its own
#include "../../../examples/own_dram.cpp"
#undef sc_main
#define sc_main own_regression_main
#include "../../../examples/own_regression.cpp"
#undef sc_main

#include "grtx/base/child_process.h"

namespace grtx::sim {
namespace {

/// The statistics of two launches on each GPU of a board, or the law that one broke; GPU after GPU.
std::vector<std::string> launched_twice(const std::function<void(GpuComponent::Options&)>& change, unsigned gpus = 1) {
  const traces::testing::TemporaryFile trace("tiny");
  test::write_tiny_trace(trace.path(), {40, 32});
  ChildProcess child("platform", [&] {
    modules::set_time_resolution_to_fs();
    GpuComponent::Options options;
    options.machine.sms = 2;
    options.traces = {trace.path()};
    change(options);
    std::deque<test::LaunchedGpu> board;
    for (unsigned gpu = 0; gpu < gpus; ++gpu) {
      board.emplace_back("gpu" + std::to_string(gpu), options, std::vector<test::TestLaunch>{{0}, {0, false, 3.5}});
    }
    sc_core::sc_start();
    nlohmann::json all = nlohmann::json::array();
    for (const test::LaunchedGpu& launched_gpu : board) {
      for (const SimulationResult& result : launched_gpu.gpu.results()) {
        all.push_back(result.violations.empty() ? test::statistics_of(result) : result.violations.front());
      }
    }
    return all.dump();
  });
  return nlohmann::json::parse(child.result()).get<std::vector<std::string>>();
}

// What it counts itself went on from the launch before: its bus had been busy for longer than the launch took.
TEST(OwnDramTwice, CountsInItsSecondLaunchWhatThatDid) {
  const auto results = launched_twice([](GpuComponent::Options& options) {
    options.memory = [](Gpu& gpu, const BuildOptions&) { return std::make_unique<SimpleMemory>(gpu, 80.0, 28.0); };
  });
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[0], results[1]);
}

TEST(OwnDramTwice, EachGpuOfABoardHasItsOwn) {
  const auto simple = [](GpuComponent::Options& options) {
    options.memory = [](Gpu& gpu, const BuildOptions&) { return std::make_unique<SimpleMemory>(gpu, 80.0, 28.0); };
  };
  const auto alone = launched_twice(simple);
  const auto board = launched_twice(simple, 2);
  ASSERT_EQ(board.size(), 4u);
  for (const std::string& statistics : board) EXPECT_EQ(statistics, alone[0]);
  EXPECT_NE(alone[0], launched_twice([](GpuComponent::Options&) {}).at(0)) << "another memory than the project's own";
}

TEST(OwnRegressionTwice, ItsSlowerSlicesRestart) {
  const auto results = launched_twice([](GpuComponent::Options& options) { slow_down(options.parts); });
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[0], results[1]);
  EXPECT_NE(results[0], launched_twice([](GpuComponent::Options&) {}).at(0)) << "slower than the project's own";
}

}  // namespace
}  // namespace grtx::sim
