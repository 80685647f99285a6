// SPDX-License-Identifier: Apache-2.0
// A search through the program: the front against brute force, constraints, resuming after SIGKILL, and what is
// refused.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "explore/sweep/sweep_bench.h"
#include "paths.h"

namespace grtx::explore {
namespace {

using nlohmann::json;
using test::Outcome;
using testing::HasSubstr;
using Texts = std::vector<std::string>;

class SearchProgram : public test::SweepBench {
 protected:
  SearchProgram() { command = "search"; }
  /// Eight designs of a tiny scene on a small machine, and another scene to evaluate on. `search`: of its section;
  /// `more`: further sections.
  void write_search(const std::string& search = "candidates = 8", const std::string& more = "") {
    write_file(folder + "/plan.toml",
               "base = '" + grtx::paths::source_dir() +
                   "/configs/small.toml'\n[tracer]\nk = 8\n"
                   "[[scene]]\npreset = 'object'\ncount = 300\nseed = 7\nwidth = 8\nheight = 8\n"
                   "[[scene]]\npreset = 'object'\ncount = 300\nseed = 8\nwidth = 8\nheight = 8\nrole = 'evaluation'\n"
                   "[[parameter]]\nkey = 'design'\nvalues = ['sw', 'grtx']\n"
                   "[[parameter]]\nkey = 'rt.warp_buffer.entries'\nvalues = [2, 4]\n"
                   "[[parameter]]\nkey = 'rt.checkpoint.lanes'\nvalues = [1, 4]\n"
                   "[[objective]]\nvalue = 'gpu.time_us'\n[[objective]]\nvalue = 'cost.rt_unit_mm2'\n"
                   "[reference]\ndesign = 'sw'\nrt.warp_buffer.entries = 4\nrt.checkpoint.lanes = 1\n"
                   "[search]\npopulation = 8\n" +
                   search + "\n" + more);
  }
  json result(const std::string& database) const {
    return json::parse(rows(database, "SELECT value FROM meta WHERE key = 'search'").at(0));
  }
};

TEST_F(SearchProgram, FindsTheFrontOfBruteForce) {
  write_search("candidates = 8\nmargin = 1.0");  // all are confirmed
  ASSERT_EQ(sweep("a.sqlite").code, 0);
  const json found = result("a.sqlite");
  EXPECT_EQ(found.at("schema"), "grtx.search/1");
  EXPECT_EQ(found.at("counts").at("candidates"), 8);
  EXPECT_EQ(found.at("counts").at("screened"), 8);
  // All eight by a sweep of their own, and what no other of them beats.
  write_file(folder + "/all.toml",
             "base = '" + grtx::paths::source_dir() +
                 "/configs/small.toml'\ndesigns = ['sw', 'grtx']\n[tracer]\nk = 8\n[[scene]]\npreset = 'object'\n"
                 "count = 300\nseed = 7\nwidth = 8\nheight = 8\n[grid]\n"
                 "rt.warp_buffer.entries = [2, 4]\nrt.checkpoint.lanes = [1, 4]\n");
  ASSERT_EQ(test::shell(grtx::paths::program() + " sweep " + folder + "/all.toml -o " + folder + "/all.sqlite").code,
            0);
  const Texts brute = rows("all.sqlite", R"(
    WITH p AS (SELECT t.value AS time, a.value AS area FROM point
               JOIN value t ON t.point_id = id AND t.name = 'gpu.time_us'
               JOIN value a ON a.point_id = id AND a.name = 'cost.rt_unit_mm2')
    SELECT DISTINCT printf('%.6e %.6e', time, area) AS pair FROM p
    WHERE NOT EXISTS (SELECT 1 FROM p AS b WHERE b.time <= p.time AND b.area <= p.area
                      AND (b.time < p.time OR b.area < p.area)) ORDER BY time)");
  EXPECT_GE(brute.size(), 2U);
  const json& reference = found.at("reference").at("confirming").at(0).at("values");
  Texts pairs;
  for (const json& at : found.at("front")) {
    const json& ratios = found.at("candidates").at(at.get<std::size_t>()).at("confirming").at("ratios");
    pairs.push_back(fmt::format("{:.6e} {:.6e}", ratios[0].get<double>() * reference[0].get<double>(),
                                ratios[1].get<double>() * reference[1].get<double>()));
  }
  EXPECT_EQ(pairs, brute);
  // The other scene was run for the front and the reference alone.
  const std::size_t evaluated = rows("a.sqlite", "SELECT id FROM point WHERE scene = 'object-300-8'").size();
  EXPECT_EQ(evaluated, found.at("counts").at("points").at("evaluation"));
  EXPECT_LE(evaluated, brute.size() + 1);
  // Nothing is left over, and nothing is run again.
  EXPECT_FALSE(std::filesystem::exists(folder + "/a.sqlite.work"));
  const Outcome again =
      sweep("a.sqlite", "--program " + program("case $1 in trace|synth) exit 9;; sim) [ $# = 4 ] || exit 9;; esac"));
  EXPECT_EQ(again.code, 0) << again.output;
  EXPECT_EQ(result("a.sqlite"), found);
}

TEST_F(SearchProgram, TheWayFromTheReferenceEndsAtTheBestDesign) {
  write_search();
  const Outcome outcome = sweep("a.sqlite");
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  const json found = result("a.sqlite");
  json here = found.at("reference").at("coordinates");
  for (const json& step : found.at("path")) {
    EXPECT_EQ(step.at("from"), here.at(step.at("key").get<std::string>()));
    here[step.at("key").get<std::string>()] = step.at("to");
  }
  const json& best = found.at("candidates").at(found.at("front").at(0).get<std::size_t>());
  ASSERT_FALSE(found.at("path").empty());  // the reference is not the fastest
  EXPECT_EQ(here, best.at("coordinates"));
  EXPECT_EQ(found.at("path").back().at("ratios"), best.at("confirming").at("ratios"));
  for (const json& of : found.at("effects")) EXPECT_EQ(of.at("parameters").size(), 3U);
  EXPECT_THAT(outcome.output, HasSubstr("8 candidates of 8"));
  EXPECT_THAT(outcome.output, HasSubstr("what each parameter contributes to gpu.time_us"));
}

TEST_F(SearchProgram, WhatIsTooDearIsNotSimulated) {
  write_search("candidates = 8", "[[constraint]]\nrule = 'cost.rt_unit_mm2 <= 0.98 * reference'\n");
  ASSERT_EQ(sweep("a.sqlite").code, 0);
  const json found = result("a.sqlite");
  EXPECT_GE(found.at("counts").at("too_dear"), 1);
  EXPECT_EQ(found.at("invalid").at(0).at("reason"), "cost.rt_unit_mm2 <= 0.98 * reference");
  EXPECT_EQ(found.at("invalid").at(0).at("candidates"), found.at("counts").at("too_dear"));
  const double bound = 0.98 * found.at("reference").at("screening").at(0).at("values").at(1).get<double>();
  std::size_t simulated = 0;
  for (const std::string& area : rows("a.sqlite",
                                      "SELECT printf('%.17g', value) FROM point JOIN value ON point_id = id AND name = "
                                      "'cost.rt_unit_mm2' WHERE scene = 'object-300-7'")) {
    simulated += std::stod(area) <= bound ? 1 : 0;
  }
  EXPECT_EQ(simulated, found.at("counts").at("screened"));
  EXPECT_EQ(simulated + 1,
            rows("a.sqlite", "SELECT id FROM point WHERE scene = 'object-300-7'").size());  // and the reference
  for (const json& at : found.at("front")) {
    EXPECT_LE(found.at("candidates").at(at.get<std::size_t>()).at("confirming").at("ratios").at(1).get<double>(), 0.98);
  }
}

// Screening took the whole image in a mode that erred by 14 %: now it is cycle mode on a smaller image, and what is
// confirmed has the whole one.
TEST_F(SearchProgram, ScreensSmallerImagesAndConfirmsTheFrontAtTheWholeSize) {
  write_search("candidates = 8\nmargin = 1.0\nscreening_scale = 0.5");
  const Outcome outcome = sweep("a.sqlite");
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("8 screened (cycle, images × 0.5), 6 confirmed (cycle)"));
  const auto rays = [&](const std::string& scene) {
    return rows(
        "a.sqlite",
        "SELECT DISTINCT mode || ' ' || (SELECT CAST(value AS INTEGER) FROM value WHERE point_id = id AND name = "
        "'gpu.distributor.groups') FROM point WHERE scene = '" +
            scene + "'");
  };
  EXPECT_EQ(rays("object-300-7-4x4"), Texts{"cycle 1"});  // 16 rays are a warp
  EXPECT_EQ(rays("object-300-7"), Texts{"cycle 2"});
  EXPECT_EQ(rays("object-300-8"), Texts{"cycle 2"}) << "the evaluation";
  const json found = result("a.sqlite");
  EXPECT_EQ(found.at("screening").at("scale"), 0.5);
  const auto microseconds = [&](const char* stage) {
    return found.at("reference").at(stage).at(0).at("values").at(0).get<double>();
  };
  EXPECT_LT(microseconds("screening"), microseconds("confirming"));
  const json& best = found.at("candidates").at(found.at("front").at(0).get<std::size_t>());
  EXPECT_NE(best.at("screening").at("ratios"), best.at("confirming").at("ratios"));
  EXPECT_EQ(best.at("confirming").at("ratios"), found.at("path").back().at("ratios")) << "whole images there, too";
}

TEST_F(SearchProgram, AScaleOfTheScreeningNeedsTheSizeOfTheImages) {
  write_search("candidates = 8\nscreening_scale = 0.5",
               "[[scene]]\nname = 'whole'\npreset = 'object'\ncount = 300\nseed = 9\n");
  const Outcome outcome = sweep("b.sqlite", "--quiet");
  EXPECT_EQ(outcome.code, 2) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("scene: search.screening_scale needs width and height"));
}

// An objective over 0: neither an infinite ratio nor one of nothing.
TEST_F(SearchProgram, AnObjectiveThatIsZeroAtTheReferenceIsRefused) {
  const std::string objective = "[[objective]]\nvalue = 'gpu.rt.checkpoint.entries_written'\n";
  write_search("candidates = 8", objective);  // the reference has no checkpoints
  const Outcome outcome = sweep("a.sqlite", "--quiet");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.output, HasSubstr("gpu.rt.checkpoint.entries_written must be above 0 at the reference, on "
                                        "object-300-7"));
  EXPECT_EQ(rows("a.sqlite", "SELECT id FROM point").size(), 1U) << "the reference alone";
}

// The search had run for hours when the reference had 0 of an objective on the evaluation scene.
TEST_F(SearchProgram, AnObjectiveThatIsZeroOnTheEvaluationSceneIsRefusedBeforeTheSearch) {
  write_search("candidates = 8", "[[objective]]\nvalue = 'gpu.rt.checkpoint.entries_written'\n");
  std::string plan = read_file(folder + "/plan.toml");
  plan.replace(plan.find("[reference]\ndesign = 'sw'"), 25, "[reference]\ndesign = 'grtx'");
  plan.replace(plan.find("count = 300\nseed = 8"), 20, "count = 1\nseed = 8");  // no second round
  write_file(folder + "/plan.toml", plan);
  const Outcome outcome = sweep("a.sqlite", "--quiet");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.output, HasSubstr("gpu.rt.checkpoint.entries_written must be above 0 at the reference, on "
                                        "object-1-8"));
  EXPECT_EQ(rows("a.sqlite", "SELECT id FROM point").size(), 2U) << "the reference on each scene";
}

TEST_F(SearchProgram, ACandidateWithZeroOfAnObjectiveHasTheRatioZero) {
  write_search("candidates = 8", "[[objective]]\nvalue = 'gpu.rt.checkpoint.entries_written'\n");
  std::string plan = read_file(folder + "/plan.toml");
  plan.replace(plan.find("[reference]\ndesign = 'sw'"), 25, "[reference]\ndesign = 'grtx'");
  write_file(folder + "/plan.toml", plan);
  ASSERT_EQ(sweep("a.sqlite").code, 0);
  const json found = result("a.sqlite");
  for (const json& candidate : found.at("candidates")) {
    const bool none = candidate.at("coordinates").at("design") == "sw";
    EXPECT_EQ(candidate.at("screening").at("ratios").at(2).get<double>() == 0.0, none) << candidate;
  }
}

TEST_F(SearchProgram, AConstraintOnAStatisticRefusesWhatWasSimulated) {
  write_search("candidates = 8", "[[constraint]]\nrule = 'gpu.time_us <= 0.0001'\n");
  EXPECT_EQ(sweep("a.sqlite").code, 1);  // no front
  const json found = result("a.sqlite");
  EXPECT_EQ(found.at("counts").at("screened"), 8);
  EXPECT_EQ(found.at("invalid"), json::parse(R"([{"outcome": "refused", "reason": "gpu.time_us <= 0.0001",
                                                  "candidates": 8}])"));
  EXPECT_TRUE(found.at("front").empty());
}

TEST_F(SearchProgram, BrokenCombinationsAreCountedByReason) {
  write_search("candidates = 32",
               "[[parameter]]\nkey = 'l1.bytes'\nvalues = [64, 4096]\n"
               "[[parameter]]\nkey = 'gpu.rt_units'\nvalues = [1, 16]\n");
  ASSERT_EQ(sweep("a.sqlite").code, 0);
  const json found = result("a.sqlite");
  EXPECT_EQ(found.at("counts").at("broken"), 24);
  EXPECT_EQ(found.at("counts").at("screened"), 8);
  EXPECT_EQ(found.at("invalid"), json::parse(R"([
    {"outcome": "broken", "reason": "configuration: l1.bytes: must hold at least l1.ways lines of l1.line_bytes",
     "candidates": 16},
    {"outcome": "broken", "reason": "configuration: gpu.rt_units: must not be more than gpu.resident_warps, or than the warps whose registers an SM holds",
     "candidates": 8}])"));
}

TEST_F(SearchProgram, WhatAMachineRefusesOnceThereIsATraceIsBrokenToo) {
  write_search("candidates = 32",
               "[[parameter]]\nkey = 'rt.any_hit_unit.enabled'\nvalues = [false, true]\n"
               "[[parameter]]\nkey = 'tracer.tracing'\nvalues = ['multi', 'single']\n");
  ASSERT_EQ(sweep("a.sqlite").code, 0);
  const json found = result("a.sqlite");
  EXPECT_EQ(found.at("counts").at("failed"), 0);
  EXPECT_EQ(found.at("counts").at("broken"), 12);  // and one round has nothing to checkpoint, whatever the machine
  EXPECT_EQ(found.at("counts").at("screened"), 20);
  EXPECT_THAT(found.at("invalid").dump(), HasSubstr("has heaps of k hits, for traces of tracing multi alone"));
}

TEST_F(SearchProgram, KilledTwiceAndResumedFindsTheSame) {
  write_search("generations = 2");
  ASSERT_EQ(sweep("undisturbed.sqlite").code, 0);
  std::filesystem::remove_all(folder + "/traces");
  std::mt19937 random(std::random_device{}());
  for (int i = 0; i < 2; ++i) {
    const std::chrono::milliseconds after(random() % 700);
    kill_sweep("killed.sqlite", after, i == 0 ? "--jobs 1" : "--jobs 2");
    SCOPED_TRACE(testing::Message() << "killed after " << after.count() << " ms");
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {  // what is there is complete
      EXPECT_EQ(entry.path().string().find(".partial"), std::string::npos);
    }
  }
  const Outcome resumed = sweep("killed.sqlite", "--jobs 3");
  EXPECT_EQ(resumed.code, 0) << resumed.output;
  const Outcome same = test::shell(grtx::paths::program() + " sweep --compare " + folder + "/undisturbed.sqlite " +
                                   folder + "/killed.sqlite");
  EXPECT_EQ(same.code, 0) << same.output;
  EXPECT_EQ(result("killed.sqlite"), result("undisturbed.sqlite"));
  EXPECT_EQ(rows("killed.sqlite", "SELECT id, key FROM point ORDER BY id", 2),
            rows("undisturbed.sqlite", "SELECT id, key FROM point ORDER BY id", 2));
}

TEST_F(SearchProgram, BadInputIsOneLine) {
  const struct {
    std::string more, message;
  } cases[] = {
      {"[[objective]]\nvalue = 'gpu.tiem_us'\n", "plan.toml: line 38: unknown value 'gpu.tiem_us', the nearest is"},
      {"[[objective]]\nvalue = 'cost.mm3'\n",
       "plan.toml: line 38: unknown value 'cost.mm3', the nearest is 'cost.mm2'"},
      {"[[constraint]]\nrule = 'cost.rt_mm2 <= 1'\n",
       "plan.toml: line 38: unknown value 'cost.rt_mm2', the nearest is"},
      {"confirm = 'cylce'\n", "plan.toml: mode: "},
      {"[set]\nl1.bytes = 64\n", "reference: configuration: l1.bytes: must hold at least"},
      {"[searhc]\n", "plan.toml: line 37: unknown key 'searhc', the nearest is 'search'"}};
  for (const auto& c : cases) {
    write_search("candidates = 8", c.more);
    const Outcome outcome = sweep("b.sqlite", "--quiet");
    EXPECT_EQ(outcome.code, 2) << outcome.output;
    EXPECT_THAT(outcome.output, HasSubstr(c.message));
    EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
  }
  EXPECT_EQ(test::shell(grtx::paths::program() + " search " + folder + "/plan.toml").code, 2);
}

}  // namespace
}  // namespace grtx::explore
