// SPDX-License-Identifier: Apache-2.0
// A figure leaves the program with what limits its meaning: on stderr, in the statistics, the results of a run, and a
// sweep's database.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "apps/first_value.h"
#include "apps/program.h"

namespace grtx::e2e {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class ResultNotes : public testing::Test {
 protected:
  ResultNotes() { must("synth --preset object --count 400 --seed 3 -o s.ply"); }

  Outcome must(const std::string& arguments) {
    Outcome outcome = folder_.run(arguments + " --quiet");
    EXPECT_EQ(outcome.code, 0) << arguments << "\n" << outcome.err;
    return outcome;
  }
  void trace(const std::string& options, const std::string& scene = "s") {
    must("trace --scene " + scene +
         ".ply --cameras s.cameras.json --width 16 --height 16 --accel tlas-tri20 -o t.grtx " + options);
  }
  /// Ids in the statistics of `grtx sim`, whose texts stderr has, too.
  std::set<std::string> of_sim(const std::string& options) {
    const Outcome outcome = must("sim t.grtx --stats n.json " + options);
    return said(json("n.json").at("notes"), outcome.err);
  }
  static std::set<std::string> said(const nlohmann::json& notes, const std::string& err) {
    std::set<std::string> ids;
    for (const nlohmann::json& note : notes) {
      EXPECT_THAT(err, HasSubstr(": " + note.at("text").get<std::string>() + "\n"));
      ids.insert(note.at("id"));
    }
    return ids;
  }
  nlohmann::json json(const std::string& name) { return nlohmann::json::parse(folder_.read(name)); }
  double cycles(const std::string& options) {
    must("sim t.grtx --stats n.json " + options);
    return json("n.json").at("stats").at("gpu.cycles").at("value");
  }
  /// The same cameras, so far away that they see nothing.
  void look_elsewhere() {
    nlohmann::json cameras = json("s.cameras.json");
    for (nlohmann::json& camera : cameras) camera.at("position") = {1e4, 1e4, 1e4};
    folder_.write("s.cameras.json", cameras.dump());
  }

  static constexpr const char* kFilled = "--set gpu.sms=1 --set gpu.resident_warps=1 ";  // by eight warps, one by one
  Folder folder_;
};

TEST_F(ResultNotes, ARunThatMeansWhatItSaysHasNone) {
  trace("");
  const Outcome outcome = must(std::string("sim t.grtx --stats n.json ") + kFilled);
  EXPECT_EQ(json("n.json").at("notes"), nlohmann::json::array());
  EXPECT_EQ(outcome.err, "");
}

TEST_F(ResultNotes, CamerasOfAnotherSceneAreNoted) {
  look_elsewhere();
  trace("");
  EXPECT_EQ(of_sim(kFilled), std::set<std::string>{"no-hits"});
  const Outcome run = must("run --scene s.ply --cameras s.cameras.json --width 16 --height 16 -o out");
  const nlohmann::json notes = json("out/results.json").at("notes");
  ASSERT_EQ(notes.size(), 6u);
  for (const auto& [design, list] : notes.items()) {
    std::set<std::string> expected = {"no-hits", "partial-launch"};
    if (design == "gautracer" || design == "walk") expected.insert("fewer-slots");  // heaps take registers
    EXPECT_EQ(said(list, run.err), expected) << design;
  }
  EXPECT_THAT(run.err, HasSubstr("grtx: baseline, gautracer, grtx, hw, sw, walk: no ray met a Gaussian"));
}

TEST_F(ResultNotes, ATailThatIsTheWholeRun) {
  trace("");
  EXPECT_EQ(of_sim(""), std::set<std::string>{"partial-launch"});
  EXPECT_THAT(json("n.json").at("notes").at(0).at("text").get<std::string>(),
              HasSubstr("a launch of 8 warps does not fill 256 warp slots, "));
}

TEST_F(ResultNotes, ListsOfOneCheckpointThatOverflowAreNoted) {
  trace("--checkpoint on --checkpoint-capacity 1");
  EXPECT_EQ(of_sim(std::string(kFilled) + "--machine ''"), std::set<std::string>{"overflow"});
}

TEST_F(ResultNotes, ClampedRowsAreNoted) {
  must("synth --preset stress-params --count 400 --seed 1 -o p.ply");
  trace("", "p");
  EXPECT_TRUE(of_sim(kFilled).contains("clamped"));
  EXPECT_THAT(folder_.run(std::string("sim t.grtx --quiet ") + kFilled).err,
              HasSubstr("reading the scene changed 12 of 517 rows: exp(scale) < 1e-6, set to 1e-6"));
}

TEST_F(ResultNotes, ASweepKeepsThemWithThePoint) {
  folder_.write("plan.toml", "[[scene]]\nfile = 's.ply'\ncameras = 's.cameras.json'\nwidth = 16\nheight = 16\n");
  must("sweep plan.toml -o db.sqlite --jobs 1");
  const std::string document = first_value(folder_.path("db.sqlite"), "SELECT document FROM point");
  const nlohmann::json notes = nlohmann::json::parse(document).at("notes");
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes.at(0).at("id"), "partial-launch");
}

// It took 11 % more cycles on paper-lean against its own trace, without a word.
TEST_F(ResultNotes, ATraceOfAnotherMachineIsNoted) {
  trace("--checkpoint on");
  for (const std::string machine : {"paper", "paper-charged"}) {
    EXPECT_FALSE(of_sim("--machine " + machine).contains("tracer-options")) << machine;
    must("sim t.grtx --strict --machine " + machine);
  }
  for (const auto& [machine, what] :
       {std::pair("paper-lean", "below_instance is checkpoint, not finish, checkpoint_bins is 0, not 4"),
        std::pair("ada-share", "child_order is slot, not near_first"),
        std::pair("rdna4-share", "bvh_width is 6, not 8")}) {
    const std::string on = std::string("--machine ") + machine;
    EXPECT_TRUE(of_sim(on).contains("tracer-options")) << machine;
    const Outcome strict = folder_.run("sim t.grtx --quiet --strict --stats none.json " + on);
    EXPECT_EQ(strict.code, 2);
    EXPECT_TRUE(is_one_error_line(strict.err)) << strict.err;
    EXPECT_THAT(strict.err, HasSubstr(std::string("t.grtx: header: ")));
    EXPECT_THAT(strict.err, HasSubstr(what));
    EXPECT_EQ(folder_.read("none.json"), "");
    trace("--checkpoint on " + on);
    EXPECT_FALSE(of_sim(on).contains("tracer-options")) << machine;
    if (machine != std::string("paper-lean")) {  // whose bins want entries of eight bytes
      EXPECT_TRUE(of_sim("--machine paper").contains("tracer-options")) << machine;
    }
    trace("--checkpoint on");
  }
}

// It took twelve times the cycles of the run, without a word.
TEST_F(ResultNotes, ATraceOfADesignWithoutItsUnitsIsNoted) {
  must("run --scene s.ply --cameras s.cameras.json --width 16 --height 16 --designs baseline,gautracer,walk -o out");
  const nlohmann::json results = json("out/results.json");
  for (const std::string design : {"gautracer", "walk"}) {
    folder_.run("sim --quiet --stats n.json out/" + design + ".grtx");
    const nlohmann::json without = json("n.json");
    const Outcome with = must("sim --design " + design + " --stats n.json out/" + design + ".grtx");
    EXPECT_EQ(json("n.json").at("stats").at("gpu.cycles"), results.at("designs").at(design).at("gpu.cycles")) << design;
    EXPECT_NE(without.at("stats").at("gpu.cycles"), json("n.json").at("stats").at("gpu.cycles")) << design;
    EXPECT_EQ(without.at("notes").at(0).at("id"), "design-keys") << design;
    EXPECT_THAT(without.at("notes").at(0).at("text").get<std::string>(),
                HasSubstr("--design " + design + " sets rt.gaussian.enabled = true, "));
    EXPECT_THAT(with.err, Not(HasSubstr("units this run lacks")));
    // What the user sets is the user's.
    EXPECT_THAT(must("sim out/" + design + ".grtx --design " + design +
                     " --set simt.registers_per_thread=40 --set simt.payload_registers=24")
                    .err,
                Not(HasSubstr("units this run lacks")));
  }
  EXPECT_THAT(must("sim out/baseline.grtx").err, Not(HasSubstr("units this run lacks")));
}

TEST_F(ResultNotes, AMachineMayHaveASeedOfSecondaryRays) {
  trace("--checkpoint on");
  folder_.write("seed.toml", "[tracer]\nsecondary_seed = 3\n");
  must("sim t.grtx --machine seed.toml");
}

TEST_F(ResultNotes, ARunNamesTracerOptionsThatAreNotItsMachines) {
  const std::string run = "run --scene s.ply --cameras s.cameras.json --width 16 --height 16 -o out ";
  EXPECT_THAT(must(run).err, Not(HasSubstr("tracer options")));
  EXPECT_THAT(must(run + "--child-order near_first").err, HasSubstr("child_order is near_first, not slot"));
}

// They were 651,112 cycles by --config, 713,312 by --machine and load_config().
TEST_F(ResultNotes, AFileStartsFromOneMachineByEachOfThreeDoors) {
  folder_.write("own.toml", "[l1]\nlatency = 25\n");
  trace("--checkpoint on");
  const double by_config = cycles("--config own.toml");
  EXPECT_EQ(cycles("--machine own.toml"), by_config);
  EXPECT_EQ(cycles("--set l1.latency=25"), by_config);  // load_config(): tests/rtl_tlm/config
  // The tracer's options are paper's as well.
  const std::string traced = folder_.read("t.grtx");
  trace("--checkpoint on --machine own.toml");
  EXPECT_EQ(folder_.read("t.grtx"), traced);
  // What a file includes is what it starts from, by each of them.
  folder_.write("of_table1.toml",
                "include = '" + grtx::paths::source_dir() + "/configs/table1.toml'\n[l1]\nlatency = 25\n");
  EXPECT_EQ(cycles("--config of_table1.toml"), cycles("--machine of_table1.toml"));
  EXPECT_EQ(cycles("--config of_table1.toml"), cycles("--machine paper-charged --set l1.latency=25"));
}

// A cache of 48 KB acted as one of 32 KB.
TEST_F(ResultNotes, ACacheThatHasNoWholeSetsIsRefused) {
  trace("");
  for (const auto& [set, rule] :
       {std::pair("l1.bytes=49152", "l1.bytes: must be a multiple of l1.ways x l1.line_bytes, as 32768 or 65536"),
        std::pair("l1.bytes=1024", "l1.bytes: must hold at least l1.ways lines"),
        std::pair("l2.slices=3",
                  "l2.bytes: must be a multiple of l2.slices x l2.ways x l2.line_bytes, as 4190208 or "
                  "4196352")}) {
    const Outcome outcome = folder_.run(std::string("sim t.grtx --quiet --set ") + set);
    EXPECT_EQ(outcome.code, 2) << set;
    EXPECT_THAT(outcome.err, HasSubstr(rule));
  }
  must("sim t.grtx --set l1.bytes=49152 --set l1.ways=128");
}

}  // namespace
}  // namespace grtx::e2e
