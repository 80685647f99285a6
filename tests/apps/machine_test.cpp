// SPDX-License-Identifier: Apache-2.0
// --machine: hardware keys and tracer options in one word, the same for every command. How it is resolved:
// tests/experiment/machine_test.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "apps/first_value.h"
#include "apps/program.h"
#include "grtx/base/atomic_file.h"
#include "paths.h"

namespace grtx::e2e {
namespace {

class MachineTest : public testing::Test {
 protected:
  MachineTest() { EXPECT_EQ(folder_.run("synth --preset object --count 500 --seed 3 -o s.ply --quiet").code, 0); }

  static constexpr const char* kView = " --scene s.ply --cameras s.cameras.json --width 16 --height 8 ";
  void must(const std::string& arguments) {
    const Outcome outcome = folder_.run(arguments);
    ASSERT_EQ(outcome.code, 0) << arguments << "\n" << outcome.err;
  }
  nlohmann::json json(const std::string& name) { return nlohmann::json::parse(folder_.read(name)); }
  Folder folder_;
};

TEST_F(MachineTest, TraceThenSimGivesTheCyclesOfRun) {
  folder_.write("over.toml", "[l1]\nlatency = 30\n");
  for (const auto& [machine, config] :
       {std::pair("", ""), std::pair("", " --config over.toml"), std::pair(" --machine paper-charged", ""),
        std::pair(" --machine ada-share", " --config over.toml")}) {
    must(std::string("run") + kView + "-o out" + machine + config);
    must(std::string("trace") + kView + "--accel tlas-tri20 --checkpoint on --k 16 -o t.grtx" + machine);
    must(std::string("sim t.grtx --quiet --stats s.json") + machine + config);
    EXPECT_EQ(folder_.read("t.grtx"), folder_.read("out/grtx.grtx")) << machine;
    const nlohmann::json run = json("out/results.json"), sim = json("s.json");
    EXPECT_EQ(sim.at("config"), run.at("config")) << machine << config;
    EXPECT_EQ(sim.at("stats").at("gpu.cycles"), run.at("designs").at("grtx").at("gpu.cycles")) << machine << config;
    EXPECT_EQ(sim.at("inputs").at("machine"), run.at("machine"));
  }
}

TEST_F(MachineTest, StatisticsSayWhetherItWasChanged) {
  must(std::string("trace") + kView + "--accel tlas-tri20 --checkpoint on -o t.grtx");
  for (const auto& [set, name] :
       {std::pair("", "paper"), std::pair(" --set l2.latency=120", "paper, changed"),
        std::pair(" --machine paper-charged", "paper-charged"), std::pair(" --machine '' --set l2.latency=120", "")}) {
    must(std::string("sim t.grtx --quiet --stats s.json") + set);
    EXPECT_EQ(json("s.json").at("inputs").at("machine"), name);
  }
}

TEST_F(MachineTest, TheCostOfARunHasTheBinsOfItsTrace) {
  must(std::string("trace") + kView + "--accel tlas-tri20 --checkpoint on -o t.grtx --machine paper-lean");
  must("sim t.grtx --quiet --machine paper-lean --stats s.json");
  const nlohmann::json energy =
      nlohmann::json::parse(folder_.run("cost --json --machine paper-lean --stats s.json").out);
  double sum = 0.0;
  for (const nlohmann::json& part : energy.at("parts")) sum += part.at("nanojoules").at("central").get<double>();
  EXPECT_NEAR(sum, json("s.json").at("stats").at("gpu.energy_nj").at("value").get<double>(), 0.01);
}

TEST_F(MachineTest, IsPaperForEveryCommandThatNamesNone) {
  const std::string plan = "[[scene]]\nfile = \"s.ply\"\ncameras = \"s.cameras.json\"\nwidth = 16\nheight = 8\n";
  folder_.write("plan.toml", plan);
  must(std::string("trace") + kView + "--accel tlas-tri20 --checkpoint on -o t.grtx --stats t.json");
  EXPECT_EQ(json("t.json").at("inputs").at("machine"), "paper");
  must("sim t.grtx --quiet --machine paper --stats s.json");
  const nlohmann::json config = json("s.json").at("config");
  EXPECT_EQ(config.at("rt.checkpoint.traffic"), "uncharged");
  EXPECT_EQ(nlohmann::json::parse(folder_.run("cost --json").out).at("config"), config);
  must("cost --quiet --stats s.json");  // refuses a run on another machine
  must("sweep plan.toml -o default.sqlite --jobs 1 --quiet");
  must("sweep plan.toml -o paper.sqlite --jobs 1 --quiet --machine paper");
  must("sweep --compare default.sqlite paper.sqlite --quiet");
}

TEST_F(MachineTest, RunSaysWhetherCheckpointTrafficIsFree) {
  for (const auto& [machine, text] :
       {std::pair("paper", "checkpoint traffic is free on this machine (paper-charged charges it)\n"),
        std::pair("paper-charged", ""),
        std::pair("ada-share --set rt.checkpoint.traffic=uncharged",
                  "checkpoint traffic is free on this machine (rt.checkpoint.traffic=charged charges it)\n")}) {
    const Outcome outcome =
        folder_.run(std::string("run") + kView + "--designs baseline,sw,hw,grtx -o out --machine " + machine);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find(": bit-identical\n"), std::string::npos) << outcome.out;
    EXPECT_EQ(outcome.out.find("checkpoint traffic is free") != std::string::npos, *text != 0) << outcome.out;
    EXPECT_TRUE(*text == 0 || outcome.out.ends_with(text)) << outcome.out;
  }
}

TEST_F(MachineTest, RunNamesItAndTheProjectsMachinesRun) {
  for (const std::string machine : {"paper", "paper-charged", "ada-share"}) {
    const Outcome outcome = folder_.run(std::string("run") + kView + "--machine " + machine + " -o " + machine);
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("machine: " + machine), std::string::npos) << outcome.out;
    const nlohmann::json results = json(machine + "/results.json");
    EXPECT_EQ(results.at("machine"), machine);
    EXPECT_TRUE(results.at("images_identical").get<bool>());
  }
}

TEST_F(MachineTest, MachinesOfOtherGpusRunAndStateWhereEachKeyIsFrom) {
  for (const std::string machine : {"ada", "ada-share", "blackwell", "blackwell-share", "rdna4", "rdna4-share",
                                    "rtx2060", "rtx2060-share", "vulkan-sim"}) {
    const Outcome outcome = folder_.run(std::string("run") + kView + "--machine " + machine + " -o " + machine);
    ASSERT_EQ(outcome.code, 0) << machine << ": " << outcome.err;
    EXPECT_TRUE(json(machine + "/results.json").at("images_identical").get<bool>());
    std::istringstream file(read_file(grtx::paths::source_dir() + "/configs/machines/" + machine + ".toml"));
    int keys = 0;
    for (std::string line; std::getline(file, line);) {
      if (line.find(" = ") == std::string::npos || line.starts_with("include") || line.starts_with("#")) continue;
      ++keys;
      EXPECT_TRUE(line.ends_with(" [B]") || line.ends_with(" [C]")) << machine << ": " << line;
    }
    EXPECT_GE(keys, machine.ends_with("-share") ? 3 : 6) << machine;
  }
}

TEST_F(MachineTest, SweepPutsItBelowThePlan) {
  folder_.write("own.toml",
                "[tracer]\nchild_order = \"slot\"\nsort_key = \"peak\"\n[l1]\nbytes = 65536\nlatency = 25\n");
  folder_.write("base.toml", "[l1]\nlatency = 30\n");
  folder_.write("plan.toml",
                "base = \"base.toml\"\n[[scene]]\nfile = \"s.ply\"\ncameras = \"s.cameras.json\"\n"
                "width = 16\nheight = 8\n[tracer]\nchild_order = \"near_first\"\n");
  must("sweep plan.toml --machine own.toml -o db.sqlite --jobs 1 --quiet");
  const auto found = [&](const char* query) {
    return nlohmann::json::parse(first_value(folder_.path("db.sqlite"), query));
  };
  const nlohmann::json config = found("SELECT config FROM point WHERE status = 'done'");
  const nlohmann::json tracer = found("SELECT options FROM trace WHERE status = 'done'").at("tracer");
  EXPECT_EQ(config.at("l1.bytes"), 65536);
  EXPECT_EQ(config.at("l1.latency"), 30);
  EXPECT_EQ(tracer.at("sort_key"), "peak");
  EXPECT_EQ(tracer.at("child_order"), "near_first");
}

}  // namespace
}  // namespace grtx::e2e
