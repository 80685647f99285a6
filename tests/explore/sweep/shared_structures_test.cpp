// SPDX-License-Identifier: Apache-2.0
// Traces of one scene and structure come from one process, which builds it once. Nobody can tell from the traces.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "explore/sweep/sweep_bench.h"
#include "paths.h"

#include "grtx/frontend/scene/scene_rows.h"

namespace grtx::explore {
namespace {

using test::Outcome;
using testing::HasSubstr;
using Texts = std::vector<std::string>;

class SharedStructures : public test::SweepBench {
 protected:
  static constexpr int kOtherView = 1;  ///< of other.cameras.json, all others are of room.cameras.json
  SharedStructures() { make_scene("room.ply", 5); }
  void make_scene(const std::string& name, int seed) const {
    const Outcome made = test::shell(grtx::paths::program() + " synth --preset object --count 300 --quiet --seed " +
                                     std::to_string(seed) + " -o " + folder + "/" + name);
    ASSERT_EQ(made.code, 0) << made.output;
  }
  /// Two views of the scene, and what is varied.
  void write_views(const std::string& varied, const std::string& scene = "room.ply") const {
    write_file(folder + "/plan.toml",
               "base = '" + grtx::paths::source_dir() + "/configs/small.toml'\n" + varied + "\n[[scene]]\nfile = '" +
                   scene + "'\ncameras = 'room.cameras.json'\nviews = [0, 3]\n" + "width = 8\nheight = 8\n");
  }
  struct Work {
    int traces = 0, structures = 0;
    bool operator==(const Work&) const = default;
  };
  /// Runs the plan, whose points must all be done.
  Work run(const std::string& database, const std::string& more = "") const {
    const Outcome outcome = sweep(database, "--quiet --json " + more);
    EXPECT_EQ(outcome.code, 0) << outcome.output;
    const auto document = nlohmann::json::parse(outcome.output, nullptr, false);
    if (!document.is_object()) return {};
    return {document.at("traces_made"), document.at("structures_built")};
  }
  /// The arguments that `grtx trace` takes for a trace of the database, but for its file.
  std::string arguments_of(const nlohmann::json& options, const std::string& scene) const {
    const int view = options.at("view").get<int>();
    std::string text = " trace --quiet --machine '' --scene " + folder + "/" + scene + " --cameras " + folder +
                       (view == kOtherView ? "/other" : "/room") + ".cameras.json --width 8 --height 8 --view " +
                       std::to_string(view);
    for (const auto& [name, value] : options.at("tracer").items()) {
      std::string flag = name;
      std::replace(flag.begin(), flag.end(), '_', '-');
      text += " --" + flag + " " + value.get<std::string>();
    }
    return text;
  }
  void expect_traces_are_those_made_alone(const std::string& database, const std::string& scene = "room.ply") const {
    const Texts paths = rows(database, "SELECT path FROM trace ORDER BY key");
    const Texts options = rows(database, "SELECT options FROM trace ORDER BY key");
    for (std::size_t i = 0; i < paths.size(); ++i) {
      const std::string alone = folder + "/alone.grtx";
      const std::string arguments = arguments_of(nlohmann::json::parse(options[i]), scene);
      const Outcome made = test::shell(grtx::paths::program() + arguments + " -o " + alone);
      ASSERT_EQ(made.code, 0) << arguments << made.output;
      EXPECT_EQ(read_file(folder + "/" + paths[i]) == read_file(alone), true) << arguments;
    }
  }
};

TEST_F(SharedStructures, AreBuiltOnceAndTracesAreThoseMadeAlone) {
  write_views("designs = ['baseline', 'sw', 'hw', 'grtx']\n[grid]\ntracer.k = [4, 8, 16]");
  EXPECT_EQ(run("a.sqlite", "--jobs 1"), (Work{24, 2}));
  expect_traces_are_those_made_alone("a.sqlite");
  // A process each, and a resumed sweep that makes no trace.
  std::filesystem::rename(folder + "/traces", folder + "/traces_of_one");
  EXPECT_EQ(run("b.sqlite", "--jobs 2"), (Work{24, 2}));
  for (const std::string& path : rows("b.sqlite", "SELECT path FROM trace")) {
    const std::string name = std::filesystem::path(path).filename();
    EXPECT_EQ(read_file(folder + "/" + path) == read_file(folder + "/traces_of_one/" + name), true) << name;
  }
  EXPECT_EQ(
      test::shell(grtx::paths::program() + " sweep --compare " + folder + "/a.sqlite " + folder + "/b.sqlite").output,
      "the same results\n");
  EXPECT_EQ(run("c.sqlite"), (Work{0, 0}));
  EXPECT_EQ(run("c.sqlite"), (Work{0, 0}));
}

struct AxisCase {
  const char* name;
  const char* values;
  int structures;
};
void PrintTo(const AxisCase& c, std::ostream* out) { *out << c.name; }

class StructuresOfAxis : public SharedStructures, public testing::WithParamInterface<AxisCase> {};

TEST_P(StructuresOfAxis, OnlyWhatChangesAStructureBuildsOne) {
  write_views("designs = ['sw']\n[grid]\ntracer." + std::string(GetParam().name) + " = " + GetParam().values);
  EXPECT_EQ(run("a.sqlite", "--jobs 1"), (Work{4, GetParam().structures}));
  expect_traces_are_those_made_alone("a.sqlite");
}

INSTANTIATE_TEST_SUITE_P(
    Of, StructuresOfAxis,
    testing::Values(AxisCase{"k", "[2, 8]", 1}, AxisCase{"ert", "[0.01, 0.1]", 1},
                    AxisCase{"sort_key", "['entry', 'peak']", 1}, AxisCase{"child_order", "['near_first', 'slot']", 1},
                    AxisCase{"tracing", "['multi', 'list']", 1}, AxisCase{"warp_size", "[8, 32]", 1},
                    AxisCase{"secondary", "['none', 'glass']", 1},
                    AxisCase{"kernel_radius", "['adaptive', '3sigma']", 2}, AxisCase{"kernel_degree", "[2, 4]", 2},
                    AxisCase{"instance_bounds", "['tight', 'box_corners']", 2}, AxisCase{"box_bits", "[6, 8]", 2},
                    AxisCase{"bvh_width", "[4, 6]", 2}, AxisCase{"layout", "['vulkan_sim', 'compact']", 2}),
    [](const auto& of) { return std::string(of.param.name); });

TEST_F(SharedStructures, TwoCameraFilesOfASceneShareOne) {
  std::filesystem::copy_file(folder + "/room.cameras.json", folder + "/other.cameras.json");
  write_views("[grid]\ntracer.k = [4, 8]");
  const std::string plan = read_file(folder + "/plan.toml");
  write_file(folder + "/plan.toml", plan +
                                        "[[scene]]\nname = 'again'\nfile = 'room.ply'\ncameras = "
                                        "'other.cameras.json'\nview = 1\nwidth = 8\nheight = 8\n");
  EXPECT_EQ(run("a.sqlite", "--jobs 1"), (Work{6, 1}));
  expect_traces_are_those_made_alone("a.sqlite");
}

TEST_F(SharedStructures, AnObjectListKeepsItsWorld) {
  write_file(folder + "/objects.json", R"([{"file": "room.ply"}, {"file": "room.ply", "translate": [3, 0, 0]}])");
  write_views("designs = ['sw', 'grtx']\n[grid]\ntracer.k = [4, 8]", "objects.json");
  EXPECT_EQ(run("a.sqlite", "--jobs 1"), (Work{8, 1}));
  expect_traces_are_those_made_alone("a.sqlite", "objects.json");
  write_views("designs = ['sw']\n[grid]\ntracer.bvh_width = [4, 5]\ntracer.k = [4, 8]", "objects.json");
  EXPECT_EQ(run("b.sqlite", "--jobs 1"), (Work{8, 2}));
  expect_traces_are_those_made_alone("b.sqlite", "objects.json");
}

TEST_F(SharedStructures, WhatDoesNotEndWellBesideOthersIsTriedAlone) {
  write_views("designs = ['sw']\n[grid]\ntracer.k = [4, 8, 16]");
  // No process for several, then one that ends after each trace.
  const std::string never = program("[ \"$1 $2\" = 'sweep --tracer' ] && exit 3");
  EXPECT_EQ(run("a.sqlite", "--jobs 1 --program " + never), (Work{6, 6}));
  expect_traces_are_those_made_alone("a.sqlite");
  std::filesystem::remove_all(folder + "/traces");
  const std::string once =
      program("[ \"$1 $2\" = 'sweep --tracer' ] && head -n 1 | exec " + grtx::paths::program() + " \"$@\" && exit 0");
  EXPECT_EQ(run("b.sqlite", "--jobs 1 --program " + once).traces, 6);
  expect_traces_are_those_made_alone("b.sqlite");
}

TEST_F(SharedStructures, EachTraceHasTheTimeOfItsLimit) {
  write_views("designs = ['sw']\n[limits]\nseconds = 1\n[grid]\ntracer.k = [4, 8]");
  const std::string hangs = program("[ \"$1 $2\" = 'sweep --tracer' ] && exec sleep 60");
  EXPECT_EQ(sweep("a.sqlite", "--jobs 1 --program " + hangs).code, 1);
  EXPECT_EQ(rows("a.sqlite", "SELECT status, reason FROM trace", 2), (Texts{4, "timeout|trace: longer than 1 s"}));
}

TEST_F(SharedStructures, ATraceThatIsRefusedStopsNoOther) {
  write_views("designs = ['sw']\n[grid]\ntracer.k = [4, 8]");
  // The one with k = 4 of view 3 kills every process that makes it.
  const std::string kills = program(
      "case \"$*\" in *'--view 3'*'--k 4'*) kill -9 $$;; esac\n"
      "[ \"$1 $2\" = 'sweep --tracer' ] && { while read -r line; do case \"$line\" in "
      "*'\"--view\",\"3\"'*'\"--k\",\"4\"'*) kill -9 $$;; esac; echo \"$line\"; done | " +
      grtx::paths::program() + " \"$@\"; exit; }");
  EXPECT_EQ(sweep("a.sqlite", "--jobs 1 --program " + kills).code, 1);
  EXPECT_EQ(rows("a.sqlite", "SELECT status, reason, count(*) FROM trace GROUP BY status", 3),
            (Texts{"done||3", "killed|trace: ended by SIGKILL|1"}));
}

/// As the process for several traces works: a line on standard input, a line of answer.
TEST_F(SharedStructures, ASceneThatWasTouchedIsReadAgain) {
  const std::string arguments = R"(["--scene", ")" + folder + R"(/room.ply", "--cameras", ")" + folder +
                                R"(/room.cameras.json", "--width", "8", "--height", "8", "--quiet", "-o", ")" + folder;
  make_scene("other.ply", 6);
  write_file(folder + "/first", arguments + "/1.grtx\"]\n");
  write_file(folder + "/second", arguments + "/2.grtx\"]\n");
  write_file(folder + "/third", arguments + "/3.grtx\"]\n");
  write_file(folder + "/script",
             "cd " + folder + "\nwait_for() { for i in $(seq 3000); do [ -e $1 ] && return; sleep 0.01; done; }\n" +
                 "{ cat first second; wait_for 2.grtx; mv other.ply room.ply; cat third; } | " +
                 grtx::paths::program() + " sweep --tracer\n");
  const Outcome answers = test::shell("sh " + folder + "/script");
  EXPECT_EQ(answers.code, 0);
  EXPECT_EQ(answers.output,
            "{\"scenes_read\":1,\"structures_built\":1}\n"
            "{\"scenes_read\":0,\"structures_built\":0}\n"
            "{\"scenes_read\":1,\"structures_built\":1}\n");
  const auto bytes = [&](const std::string& name) { return read_file(folder + "/" + name); };
  EXPECT_EQ(bytes("1.grtx") == bytes("2.grtx"), true);
  EXPECT_EQ(bytes("1.grtx") == bytes("3.grtx"), false);
  ASSERT_EQ(test::shell(grtx::paths::program() + " trace --scene " + folder + "/room.ply --cameras " + folder +
                        "/room.cameras.json --width 8 --height 8 --quiet -o " + folder + "/alone.grtx")
                .code,
            0);
  EXPECT_EQ(bytes("3.grtx") == bytes("alone.grtx"), true);
}

/// The scene of a generation's traces is made in the folder of traces, and kept like any other.
TEST_F(SharedStructures, AGeneratedSceneIsKeptToo) {
  write_plan();
  EXPECT_EQ(run("a.sqlite", "--jobs 2"), (Work{2, 1}));
}

TEST_F(SharedStructures, AreSaidInTheSummary) {
  write_plan();
  EXPECT_THAT(sweep("a.sqlite", "--jobs 2").output, HasSubstr("\n2 traces made, 1 structure built for them\n"));
  EXPECT_THAT(sweep("a.sqlite", "--jobs 2").output, testing::Not(HasSubstr("made")));
}

}  // namespace
}  // namespace grtx::explore
