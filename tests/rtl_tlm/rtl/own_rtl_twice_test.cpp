// SPDX-License-Identifier: Apache-2.0
// examples/own_rtl: its block, launched twice on a GpuComponent, gives the same figures twice.
#include "Vown_ray_box.h"  // before SystemC

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "rtl_tlm/platform/platform_bench.h"
#include "rtl_tlm/tiny_trace.h"
#include "traces/temporary_file.h"

#define sc_main own_rtl_main  // the test has one of its own
#include "../../../examples/own_rtl.cpp"
#undef sc_main

#include "grtx/base/child_process.h"

namespace grtx::sim {
namespace {

TEST(OwnRtlTwice, ItsBlockRestarts) {
  const traces::testing::TemporaryFile trace("tiny");
  test::write_tiny_trace(trace.path(), {40, 32});
  ChildProcess child("platform", [&] {
    modules::set_time_resolution_to_fs();
    GpuComponent::Options options;
    options.machine.sms = 2;
    options.traces = {trace.path()};
    options.parts.sm.rt_parts.ray_box = [](const char* name, const modules::RtUnitContext&) {
      return std::make_unique<OwnRayBox>(name);
    };
    test::LaunchedGpu launched("gpu0", options, {{0}, {0, false, 3.5}});
    sc_core::sc_start();
    nlohmann::json all = nlohmann::json::array();
    for (const SimulationResult& result : launched.gpu.results()) all.push_back(test::statistics_of(result));
    return all.dump();
  });
  const auto results = nlohmann::json::parse(child.result()).get<std::vector<std::string>>();
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[0], results[1]);
}

}  // namespace
}  // namespace grtx::sim
