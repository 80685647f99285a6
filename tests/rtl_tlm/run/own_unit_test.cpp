// SPDX-License-Identifier: Apache-2.0
// examples/own_unit: its key, statistics, energy and signals are the program's own, and it takes 80 lines.
#include <gtest/gtest.h>

#include <fstream>

#include "grtx/rtl_tlm/run/statistics_json.h"
#include "paths.h"
#include "rtl_tlm/observe/observed_run.h"

namespace grtx::sim {
namespace {

class OwnUnit : public ::testing::Test {
 protected:
  /// Runs the example; returns what it printed.
  std::string own_unit(const std::string& arguments, int code = 0) const {
    const std::string output = run_.path("output");
    const std::string command = "'" + grtx::paths::own_unit() + "' " + arguments + " > '" + output + "' 2>&1";
    const int status = std::system(command.c_str());
    std::ifstream file(output);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    EXPECT_EQ(WEXITSTATUS(status), code) << text;
    return text;
  }
  nlohmann::ordered_json simulated(const std::string& arguments) const {
    own_unit("sim '" + run_.path("t.grtx") + "' --quiet --stats '" + run_.path("s.json") + "' " + arguments);
    return read_statistics(run_.path("s.json"));
  }
  test::ObservedRun run_;
};

TEST_F(OwnUnit, HasItsKeyStatisticsAndEnergy) {
  const auto quick = simulated("--set rt.resting_box.rest=0"), slow = simulated("--set rt.resting_box.rest=40");
  EXPECT_EQ(slow.at("config").at("rt.resting_box.rest"), 40);
  const std::uint64_t tests = test::statistic(slow.at("stats"), "gpu.rt.resting_box.tests");
  EXPECT_GT(tests, 0u);
  EXPECT_EQ(test::statistic(quick.at("stats"), "gpu.rt.resting_box.tests"), tests);
  EXPECT_EQ(test::statistic(slow.at("stats"), "gpu.rt.resting_box.rested"), 40 * tests);
  EXPECT_GT(test::statistic(slow.at("stats"), "gpu.cycles"), test::statistic(quick.at("stats"), "gpu.cycles"));
  EXPECT_NEAR(slow.at("stats").at("gpu.energy_nj.own").at("value").get<double>(), 21e-3 * static_cast<double>(tests),
              1e-3);
}

TEST_F(OwnUnit, ItsKeyIsOneOfAMachineAndHasARange) {
  std::ofstream(run_.path("mine.toml")) << "[rt.resting_box]\nrest = 7\n";
  EXPECT_EQ(simulated("--machine '" + run_.path("mine.toml") + "'").at("config").at("rt.resting_box.rest"), 7);
  const std::string text = own_unit("sim '" + run_.path("t.grtx") + "' --set rt.resting_box.rest=-1", 2);
  EXPECT_NE(text.find("rt.resting_box.rest"), std::string::npos) << text;
  EXPECT_NE(own_unit("sim --list-config").find("rt.resting_box"), std::string::npos);
}

TEST_F(OwnUnit, ItsSignalsAreInTheWaveform) {
  simulated("--vcd '" + run_.path("w.vcd") + "' --vcd-scope 'sm0.rt.ray_box'");
  std::ifstream file(run_.path("w.vcd"));
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(text.find("waiting"), std::string::npos);
  EXPECT_NE(text.find("rested"), std::string::npos);
}

TEST_F(OwnUnit, CountsInItsSecondLaunchWhatThatDid) {
  const auto once = simulated(""), twice = simulated("--warm '" + run_.path("t.grtx") + "'");
  for (const char* name : {"gpu.rt.resting_box.tests", "gpu.rt.resting_box.rested", "gpu.rt.node_visits"}) {
    EXPECT_EQ(test::statistic(twice.at("stats"), name), test::statistic(once.at("stats"), name)) << name;
  }
}

TEST_F(OwnUnit, TakesEightyLines) {
  std::ifstream file(grtx::paths::source_dir() + "/examples/own_unit.cpp");
  const auto lines = std::count(std::istreambuf_iterator<char>(file), {}, '\n');
  EXPECT_LE(lines, 1 + 80) << "beside its licence line";
}

}  // namespace
}  // namespace grtx::sim
