// SPDX-License-Identifier: Apache-2.0
// Delayed any-hit shaders, and early termination tested once per round, through the program: images, sound traces, what
// the hardware model says of them, machines and plans.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "apps/program.h"
#include "paths.h"

namespace grtx::e2e {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class AnyHit : public ::testing::Test {
 protected:
  void SetUp() override { must("synth --preset flat --count 1500 --seed 3 -o s.ply --quiet"); }
  void must(const std::string& arguments) {
    const Outcome outcome = folder_.run(arguments);
    ASSERT_EQ(outcome.code, 0) << arguments << "\n" << outcome.err;
  }
  void trace(const std::string& name, const std::string& options) {
    must("trace --quiet --scene s.ply --cameras s.cameras.json --width 16 --height 8 -o " + name + ".grtx --image " +
         name + ".pfm --stats " + name + ".json " + (options.find("--k ") == options.npos ? "--k 4 " : "") + options);
  }
  double stat(const std::string& file, const std::string& name) {
    return nlohmann::json::parse(folder_.read(file)).at("stats").at(name).at("value").get<double>();
  }
  nlohmann::json dumped(const std::string& name) {
    const std::string text = folder_.run("trace-dump --json " + name + ".grtx").out;
    return nlohmann::json::parse(text.substr(0, text.find('\n')));
  }
  std::string small() const { return " --quiet --config '" + grtx::paths::source_dir() + "/configs/small.toml' "; }

  Folder folder_;
};

TEST_F(AnyHit, DelayedGivesTheSameImageAndASoundTraceOfTheEleventhVersion) {
  for (const std::string accel : {"tri20", "tlas-sphere", "box"}) {
    for (const std::string order : {"--tmax-update reported", "--tmax-update kth --child-order slot"}) {
      trace("immediate", "--accel " + accel + " " + order);
      trace("delayed", "--any-hit delayed --accel " + accel + " " + order);
      EXPECT_THAT(folder_.run("compare immediate.pfm delayed.pfm").out, HasSubstr("identical")) << accel;
      must("trace-check --quiet delayed.grtx");
      EXPECT_GT(stat("delayed.json", "tracer.visits.total"), stat("immediate.json", "tracer.visits.total"));
      EXPECT_EQ(stat("delayed.json", "tracer.rounds"), stat("immediate.json", "tracer.rounds"));
      EXPECT_EQ(dumped("delayed").at("version"), 11);
      EXPECT_FALSE(dumped("immediate").at("header").contains("any_hit"));
      EXPECT_FALSE(dumped("immediate").at("header").at("inputs").contains("any_hit")) << "as on record";
    }
  }
}

// Shaders run behind the traversal of their round: nothing is pruned, and a call is a call of the same work.
TEST_F(AnyHit, DelayedTracesRunInEveryMode) {
  for (const std::string accel : {"ellipsoid", "box"}) {
    trace("delayed", "--any-hit delayed --accel " + accel);
    for (const std::string mode : {"", "--mode windows"}) {
      must("sim delayed.grtx " + mode + small() + "--stats s.json");
      EXPECT_EQ(stat("s.json", "gpu.rt.node_visits"), stat("delayed.json", "tracer.visits.total")) << mode;
      EXPECT_EQ(stat("s.json", "gpu.simt.any_hit.calls"), stat("delayed.json", "tracer.any_hit.calls")) << mode;
      EXPECT_GT(stat("s.json", "gpu.simt.lsu.loads.eviction"), 0.0) << "the lists of hits";
    }
  }
}

TEST_F(AnyHit, AMachineMayChooseItAndItsResultsSayWhenATraceIsOfAnother) {
  folder_.write("own.toml", "[tracer]\nany_hit = \"delayed\"\n");
  trace("own", "--accel ellipsoid --machine own.toml");
  EXPECT_EQ(dumped("own").at("header").at("any_hit"), "delayed");
  EXPECT_EQ(dumped("own").at("header").at("inputs").at("any_hit"), "delayed");
  trace("other", "--accel ellipsoid --machine own.toml --any-hit immediate");
  const Outcome strict = folder_.run("sim other.grtx --quiet --strict --machine own.toml --stats none.json");
  EXPECT_EQ(strict.code, 2);
  EXPECT_THAT(strict.err, HasSubstr("any_hit is immediate, not delayed"));
}

TEST_F(AnyHit, TheEndTestedOnceARoundIsSimulatedAndDependsOnK) {
  const std::string ends_early = "--accel ellipsoid --ert 0.3 ";
  trace("hit", ends_early);
  trace("round", ends_early + "--ert-check round");
  trace("one", ends_early + "--ert-check round --k 1");
  EXPECT_THAT(folder_.run("compare hit.pfm one.pfm").out, HasSubstr("identical")) << "a round of one hit";
  EXPECT_THAT(folder_.run("compare hit.pfm round.pfm").out, Not(HasSubstr("identical")));
  EXPECT_GT(stat("round.json", "tracer.blended"), stat("hit.json", "tracer.blended"));
  EXPECT_EQ(stat("round.json", "tracer.visits.total"), stat("hit.json", "tracer.visits.total"));
  EXPECT_EQ(dumped("round").at("header").at("ert_check"), "round");
  EXPECT_EQ(dumped("round").at("version"), 11);
  must("trace-check --quiet round.grtx");
  must("sim round.grtx --stats sim.json" + small());
  EXPECT_EQ(stat("sim.json", "gpu.rt.node_visits"), stat("round.json", "tracer.visits.total"));
}

TEST_F(AnyHit, ARunComparesImagesOfOneK) {
  must("run --scene s.ply --cameras s.cameras.json --width 16 --height 8 --ert 0.3 --ert-check round --k 8 -o out" +
       small());
  const auto results = nlohmann::json::parse(folder_.read("out/results.json"));
  EXPECT_TRUE(results.at("images_identical").get<bool>());
  EXPECT_EQ(results.at("inputs").at("grtx").at("trace.ert_check"), "round");
}

}  // namespace
}  // namespace grtx::e2e
