// SPDX-License-Identifier: Apache-2.0
// grtx sim from the outside: statistics file, summary, waveform, configuration list.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "apps/program.h"
#include "paths.h"
#include "rtl_tlm/tiny_trace.h"

namespace grtx::e2e {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const std::string kSmall = std::string("--config '") + grtx::paths::source_dir() + "/configs/small.toml' ";

class CliSim : public ::testing::Test {
 protected:
  CliSim() { sim::test::write_tiny_trace(folder_.path("t.grtx")); }
  Folder folder_;
};

TEST_F(CliSim, WritesTheStatisticsFile) {
  const Outcome outcome = folder_.run("sim t.grtx " + kSmall + "--stats s.json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("cycles"));
  EXPECT_THAT(outcome.out, HasSubstr("host: "));
  const auto json = nlohmann::ordered_json::parse(folder_.read("s.json"));
  EXPECT_EQ(json.at("schema"), "grtx.stats/1");
  EXPECT_EQ(json.at("config").at("gpu.sms"), 2);
  EXPECT_EQ(json.at("inputs").at("trace.scene"), "tiny");
  EXPECT_EQ(json.at("inputs").at("trace_hash").get<std::string>().size(), 16U);
  EXPECT_GT(json.at("stats").at("gpu.cycles").at("value").get<std::uint64_t>(), 0U);
}

TEST_F(CliSim, TwoRunsDifferInHostStatisticsOnly) {
  ASSERT_EQ(folder_.run("sim t.grtx --quiet --stats a.json").code, 0);
  ASSERT_EQ(folder_.run("sim t.grtx --quiet --stats b.json --construction-order 9 --no-idle-skip").code, 0);
  const std::string a = folder_.read("a.json"), b = folder_.read("b.json");
  const std::size_t host = a.find("\"host.");
  ASSERT_NE(host, std::string::npos);
  EXPECT_EQ(a.substr(0, host), b.substr(0, host));
}

TEST_F(CliSim, QuietPrintsNothing) {
  const Outcome outcome =
      folder_.run("sim t.grtx --quiet --set gpu.sms=1 --set gpu.resident_warps=1");  // four warps long
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(outcome.err, "");
}

TEST_F(CliSim, AModeThatIsGoneNamesWhatTookItsPlace) {
  folder_.write("sweep.toml", "mode = 'sampled'\n[[scene]]\npreset = 'object'\n[grid]\ngpu.sms = [1]\n");
  for (const char* mode : {"fast", "sampled"}) {
    const std::string says = fmt::format("mode '{}' is gone: use cycle; of whole frames, windows", mode);
    for (const std::string command : {"sim t.grtx", "run --scene s.ply --cameras s.cameras.json -o out"}) {
      const Outcome outcome = folder_.run(command + " --mode " + mode);
      EXPECT_EQ(outcome.code, 2);
      EXPECT_TRUE(is_one_error_line(outcome.err)) << outcome.err;
      EXPECT_THAT(outcome.err, HasSubstr(says));
    }
  }
  const Outcome sweep = folder_.run("sweep sweep.toml -o s.sqlite");
  EXPECT_EQ(sweep.code, 2);
  EXPECT_TRUE(is_one_error_line(sweep.err)) << sweep.err;
  EXPECT_THAT(sweep.err, HasSubstr("mode 'sampled' is gone: use cycle; of whole frames, windows"));
}

TEST_F(CliSim, SettingsComeAfterTheFile) {
  const Outcome outcome =
      folder_.run("sim t.grtx --quiet --stats s.json " + kSmall + "--set gpu.sms=3 --set l1.latency=25");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::ordered_json::parse(folder_.read("s.json"));
  EXPECT_EQ(json.at("config").at("gpu.sms"), 3);
  EXPECT_EQ(json.at("config").at("l1.latency"), 25);
}

TEST_F(CliSim, AnL1ThatDropsFillsSaysSo) {
  const std::string trace = "sim '" + grtx::paths::source_dir() + "/data/traces/grtx.grtx' --quiet " + kSmall +
                            "--set l1.bytes=4096 --set l1.ways=1 --set l1.private_writes=write_back "
                            "--set l1.private_allocate=true ";
  const std::string run = trace + "--set l1.write_back_buffer=";
  EXPECT_THAT(folder_.run(run + "1").err,
              AllOf(HasSubstr("grtx: sim: "), HasSubstr(" % of the fills of the L1 were dropped"),
                    HasSubstr("l1.write_back_buffer\n")));
  EXPECT_THAT(folder_.run(run + "64").err, Not(HasSubstr("dropped")));
}

TEST_F(CliSim, WritesAWaveformThatGtkwavesConverterReads) {
  if (std::system("command -v vcd2fst > /dev/null") != 0) GTEST_SKIP() << "vcd2fst (package gtkwave) is not installed";
  ASSERT_EQ(folder_.run("sim t.grtx --quiet --vcd w.vcd --vcd-scope 'gpu.sm0*' --vcd-window 100:900").code, 0);
  EXPECT_EQ(std::system(("vcd2fst '" + folder_.path("w.vcd") + "' '" + folder_.path("w.fst") + "' >/dev/null").c_str()),
            0);
  EXPECT_TRUE(folder_.has("w.fst"));
}

TEST_F(CliSim, ASavedStateGivesTheStatisticsOfWarm) {
  const std::string run = "sim t.grtx --quiet " + kSmall;
  for (const std::string mode : {"", "--mode cycle "}) {
    ASSERT_EQ(folder_.run(run + mode + "--save-state t.state").code, 0);
    ASSERT_EQ(folder_.run(run + mode + "--stats cold.json").code, 0);
    ASSERT_EQ(folder_.run(run + mode + "--warm t.grtx --stats one.json").code, 0);
    ASSERT_EQ(folder_.run(run + mode + "--warm-state t.state --stats two.json").code, 0);
    const auto statistics = [this](const char* file) {
      const std::string text = folder_.read(file);
      return text.substr(0, text.find("\"host."));  // the last ones
    };
    EXPECT_THAT(statistics("two.json"), HasSubstr("gpu.cycles")) << mode;
    EXPECT_EQ(statistics("two.json"), statistics("one.json")) << mode;
    EXPECT_NE(statistics("two.json"), statistics("cold.json")) << mode;
  }
}

TEST_F(CliSim, AStateThatIsDamagedOrOfAnotherMachineIsRefusedInOneLine) {
  const std::string run = "sim t.grtx --quiet " + kSmall;
  ASSERT_EQ(folder_.run(run + "--save-state t.state").code, 0);
  const auto refused = [&](const std::string& arguments, const std::string& why) {
    const Outcome outcome = folder_.run(run + arguments + " --stats s.json");
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_TRUE(is_one_error_line(outcome.err)) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(why)) << arguments;
    EXPECT_FALSE(folder_.has("s.json")) << arguments;
  };
  refused("--warm-state t.state --set gpu.sms=3", "t.state: machine: is another");
  refused("--warm-state t.state --warm t.grtx", "sim: --warm-state: ");
  refused("--warm-state t.grtx", "t.grtx: ");
  refused("--warm-state none.state", "none.state");
  std::string damaged = folder_.read("t.state");
  damaged[damaged.size() / 2] ^= 1;
  folder_.write("t.state", damaged);
  refused("--warm-state t.state", "t.state: ");
}

// Equal addresses are other bytes there: DRAM reads fell from 7,016 to 1,619.
TEST_F(CliSim, AWarmTraceOfAnotherSceneIsRefused) {
  const auto trace = [&](const std::string& scene, const std::string& options, const std::string& file) {
    ASSERT_EQ(folder_
                  .run("trace --quiet --scene " + scene + ".ply --cameras " + scene +
                       ".cameras.json --width 16 --height 8 --accel tlas-tri20 " + options + " -o " + file)
                  .code,
              0);
  };
  for (const std::string seed : {"1", "2"}) {
    ASSERT_EQ(folder_.run("synth --quiet --preset object --count 400 --seed " + seed + " -o " + seed + ".ply").code, 0);
  }
  trace("1", "", "one.grtx");
  trace("1", "--view 1", "view.grtx");
  trace("1", "--kernel-radius 3sigma", "radius.grtx");
  trace("2", "", "two.grtx");
  ASSERT_EQ(folder_.run("sim one.grtx --quiet --save-state one.state").code, 0);
  EXPECT_EQ(folder_.run("sim view.grtx --quiet --warm one.grtx").code, 0);
  EXPECT_EQ(folder_.run("sim view.grtx --quiet --warm-state one.state").code, 0);
  for (const std::string other : {"two.grtx", "radius.grtx"}) {
    for (const std::string warm : {"--warm one.grtx", "--warm-state one.state"}) {
      const Outcome outcome = folder_.run("sim " + other + " --quiet --stats none.json " + warm);
      EXPECT_EQ(outcome.code, 2) << other << warm;
      EXPECT_TRUE(is_one_error_line(outcome.err)) << outcome.err;
      EXPECT_THAT(outcome.err, HasSubstr("another")) << outcome.err;
      EXPECT_FALSE(folder_.has("none.json"));
    }
  }
}

TEST_F(CliSim, AnOldResultStaysWhenARunFails) {
  folder_.write("s.json", "old");
  EXPECT_EQ(folder_.run("sim t.grtx --quiet --stats s.json --vcd /dev/full").code, 2);
  EXPECT_EQ(folder_.read("s.json"), "old");
}

}  // namespace
}  // namespace grtx::e2e
