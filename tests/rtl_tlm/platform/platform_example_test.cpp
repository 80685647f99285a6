// SPDX-License-Identifier: Apache-2.0
// examples/platform: two GPUs, each launched twice, take the cycles of `grtx sim` for each launch.
#include <gtest/gtest.h>

#include <fstream>

#include "grtx/rtl_tlm/run/statistics_json.h"
#include "paths.h"
#include "rtl_tlm/observe/observed_run.h"

namespace grtx::sim {
namespace {

TEST(PlatformExample, EachLaunchTakesTheCyclesOfGrtxSim) {
  const test::ObservedRun one(true, true), folder(true, true);
  const std::string a = one.path("t.grtx"), b = folder.path("b.grtx");
  traces::testing::RandomOptions random{.seed = 12, .groups = 30, .warp_size = 32, .capacity = 1000, .two_level = true};
  auto trace = traces::testing::random_trace(random);
  for (traces::RayGroup& group : trace.groups) group.kind = traces::RayKind::primary;
  traces::testing::write_trace(b, trace.header, trace.groups);
  const std::string machine = grtx::paths::source_dir() + "/configs/small.toml";
  const auto shell = [&](const std::string& command) {
    const std::string output = folder.path("output");
    const int status = std::system((command + " > '" + output + "' 2>&1").c_str());
    std::ifstream file(output);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    EXPECT_EQ(status, 0) << text;
    return text;
  };
  const auto cycles = [&](const std::string& path) {
    const std::string statistics = folder.path("s.json");
    shell("'" + grtx::paths::program() + "' sim '" + path + "' --quiet --machine '" + machine + "' --stats '" +
          statistics + "'");
    return test::statistic(read_statistics(statistics).at("stats"), "gpu.cycles");
  };
  const std::uint64_t of_a = cycles(a), of_b = cycles(b);
  EXPECT_NE(of_a, of_b);
  const std::string text = shell("'" + grtx::paths::platform() + "' '" + machine + "' '" + a + "' '" + b + "'");
  const auto line = [&](const char* gpu, unsigned launch, unsigned number, std::uint64_t expected) {
    const std::string wanted = std::string(gpu) + " launch " + std::to_string(launch) + ": trace " +
                               std::to_string(number) + ", " + std::to_string(expected) + " cycles, error 0\n";
    EXPECT_NE(text.find(wanted), std::string::npos) << wanted << text;
  };
  line("gpu0", 0, 0, of_a);
  line("gpu1", 0, 1, of_b);
  line("gpu0", 1, 1, of_b);
  line("gpu1", 1, 0, of_a);
}

}  // namespace
}  // namespace grtx::sim
