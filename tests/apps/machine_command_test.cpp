// SPDX-License-Identifier: Apache-2.0
// grtx machine: every key with its value, where it comes from and on whose word; bandwidth in GB/s, and the key for it.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "apps/program.h"
#include "paths.h"

namespace grtx::e2e {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

class MachineCommand : public ::testing::Test {
 protected:
  json resolved(const std::string& arguments) {
    const Outcome outcome = folder_.run("machine --json " + arguments);
    EXPECT_EQ(outcome.code, 0) << arguments << ": " << outcome.err;
    return json::parse(outcome.out);
  }
  double figure(const std::string& arguments, const std::string& name) {
    return resolved(arguments).at("figures").at(name).at("value");
  }
  Folder folder_;
  const std::string own_ = grtx::paths::source_dir() + "/configs/own_machine.toml";
};

TEST_F(MachineCommand, SaysWhereEachValueComesFromAndOnWhoseWord) {
  const json keys = resolved("ada --set l1.bytes=65536").at("keys");
  EXPECT_EQ(keys.at("gpu.sms").at("value"), 128);
  EXPECT_THAT(keys.at("gpu.sms").at("from").get<std::string>(), ::testing::MatchesRegex("ada.toml:[0-9]+"));
  EXPECT_EQ(keys.at("gpu.sms").at("source"), "NVIDIA, Ada white paper: RTX 4090 [B]");
  EXPECT_EQ(keys.at("gpu.sms").at("confidence"), "") << "the file's own value: its comment says it";
  EXPECT_EQ(keys.at("l1.bytes").at("value"), 65536);
  EXPECT_EQ(keys.at("l1.bytes").at("from"), "--set");
  EXPECT_EQ(keys.at("dram.queue").at("from"), "default");
  EXPECT_EQ(keys.at("dram.queue").at("confidence"), "B");
  EXPECT_EQ(keys.at("tracer.child_order").at("value"), "near_first");
  EXPECT_THAT(keys.at("dram.banks").at("from").get<std::string>(), HasSubstr("gddr6.toml:"));
}

TEST_F(MachineCommand, PrintsALineAKeyAndThenTheFigures) {
  const Outcome outcome = folder_.run("machine ada");
  EXPECT_THAT(outcome.out, HasSubstr("gpu.sms                         128 SMs           ada.toml:"));
  EXPECT_THAT(outcome.out, HasSubstr("\nDRAM bandwidth                  1008 GB/s         from dram.bandwidth_gb_s"));
  EXPECT_EQ(folder_.run("machine").out, folder_.run("machine paper").out);
}

TEST_F(MachineCommand, ShowsOneBandwidthForFourWaysToDoubleIt) {
  EXPECT_DOUBLE_EQ(figure("paper", "DRAM bandwidth"), 112.0);
  for (const char* way : {"dram.timing.ccd=2", "dram.mhz=7000", "l2.slices=8", "dram.bandwidth_gb_s=224"}) {
    EXPECT_DOUBLE_EQ(figure(std::string("paper --set ") + way, "DRAM bandwidth"), 224.0) << way;
  }
  // Latency stays with the key alone and with ccd, half of whose clocks are saved.
  const double before = figure("paper", "DRAM read, row closed");
  EXPECT_NEAR(figure("paper --set dram.bandwidth_gb_s=224", "DRAM read, row closed"), before, 4 / 3.5);
  EXPECT_LT(figure("paper --set dram.mhz=7000", "DRAM read, row closed"), 0.6 * before);
}

TEST_F(MachineCommand, TheBandwidthKeyIsAFasterClockWhoseTimesStay) {
  ASSERT_EQ(folder_.run("synth --preset flat --count 2000 --seed 1 -o s.ply --quiet").code, 0);
  ASSERT_EQ(folder_
                .run("trace --scene s.ply --cameras s.cameras.json --width 16 --height 16 --accel tlas-tri20 "
                     "--checkpoint on -o t.grtx --quiet")
                .code,
            0);
  const auto cycles = [&](const std::string& settings) {
    const Outcome outcome = folder_.run("sim t.grtx --json --quiet --machine paper-charged " + settings);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return json::parse(outcome.out).at("stats").at("gpu.cycles").at("value").get<double>();
  };
  const std::string doubled =
      "--set dram.mhz=7000 --set dram.fixed_latency=512 --set dram.age_cap=2048 --set dram.timing.rrd=20 "
      "--set dram.timing.rcd=40 --set dram.timing.ras=100 --set dram.timing.rp=40 --set dram.timing.rc=124 "
      "--set dram.timing.cl=40 --set dram.timing.wl=16 --set dram.timing.cdlr=18 --set dram.timing.wr=40 "
      "--set dram.timing.rtp=8";
  EXPECT_EQ(cycles("--set dram.bandwidth_gb_s=224"), cycles(doubled));
  EXPECT_EQ(cycles("--set dram.bandwidth_gb_s=112"), cycles("")) << "what it is already";
}

// walk's machine tests no triangles.
TEST_F(MachineCommand, ListsNoRateOfAUnitThatADesignHasNot) {
  const json walk = resolved("paper --design walk").at("figures"), none = resolved("paper").at("figures");
  EXPECT_FALSE(walk.contains("triangle tests"));
  EXPECT_DOUBLE_EQ(walk.at("gaussian tests").at("value"), none.at("triangle tests").at("value"));  // four each
  EXPECT_FALSE(none.contains("gaussian tests"));
  EXPECT_EQ(resolved("paper --design grtx").at("figures"), none);
}

// `k = 0` was shown as a machine, and a bandwidth that nobody sets as 0.0 GB/s.
TEST_F(MachineCommand, RefusesWhatNoTracerTakesAndSaysWhatIsNotSet) {
  folder_.write("zero.toml", "[tracer]\nk = 0\n");
  for (const char* command : {"machine zero.toml", "machine --config zero.toml", "cost --machine zero.toml"}) {
    const Outcome outcome = folder_.run(command);
    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("zero.toml: line 2: tracer.k: must be 1 to 2048, not 0")) << command;
  }
  EXPECT_THAT(folder_.run("machine").out, HasSubstr("dram.bandwidth_gb_s             not set           default"));
}

TEST_F(MachineCommand, TheMachineOfTheGuideIsWhatItSaysAndRuns) {
  const json machine = resolved("'" + own_ + "'");
  EXPECT_EQ(machine.at("keys").at("gpu.sms").at("value"), 16);
  EXPECT_EQ(machine.at("keys").at("l1.bytes").at("value"), 262144);
  EXPECT_EQ(machine.at("keys").at("rt.checkpoint.traffic").at("value"), "charged");
  EXPECT_DOUBLE_EQ(machine.at("figures").at("DRAM bandwidth").at("value"), 224.0);
  ASSERT_EQ(folder_.run("synth --preset flat --count 1000 --seed 1 -o s.ply --quiet").code, 0);
  const Outcome run = folder_.run("run --scene s.ply --cameras s.cameras.json --width 16 --height 16 --designs " +
                                  std::string("baseline,grtx --quiet -o out --machine '") + own_ + "'");
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(json::parse(folder_.read("out/results.json")).at("machine"), "own_machine");
}

}  // namespace
}  // namespace grtx::e2e
