// SPDX-License-Identifier: Apache-2.0
// A database that one plan has filled and another goes on with: what the present plan does not ask for is of an earlier
// plan, is called by whatever tells it apart, and takes part in nothing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "explore/sweep/sweep_bench.h"
#include "grtx/report/page/sweep_results.h"
#include "grtx/report/page/sweep_views.h"
#include "paths.h"

namespace grtx::report {
namespace {

using test::Outcome;
using testing::ElementsAre;
using testing::HasSubstr;
using Texts = std::vector<std::string>;

struct Edit {
  const char *name, *before, *after;  ///< lines of the plan
  const char* differs;                ///< the coordinate that tells the points apart
};

class EditedPlan : public explore::test::SweepBench {
 protected:
  /// Two designs with two warp buffers; in scene: further lines of the scene.
  void write(const std::string& in_scene, const std::string& more = "") {
    write_file(folder + "/plan.toml",
               "designs = ['baseline', 'grtx']\n"
               "[[scene]]\npreset = 'object'\ncount = 300\nseed = 7\n" +
                   in_scene + "\n[grid]\nrt.warp_buffer.entries = [4, 8]\n" + more);
  }
  void fill(const std::string& database, const std::string& more = "") {
    const Outcome outcome = sweep(database, more + " --quiet");
    ASSERT_EQ(outcome.code, 0) << outcome.output;
  }
  SweepResults results(const std::string& database) const { return read_sweep_results(folder + "/" + database); }
  std::string compare(const std::string& a, const std::string& b) const {
    return test::shell(grtx::paths::program() + " sweep --compare " + folder + "/" + a + " " + folder + "/" + b).output;
  }
  std::string report(const std::string& database) const {
    const std::string page = folder + "/" + database + ".html";
    const Outcome outcome = test::shell(grtx::paths::program() + " report " + folder + "/" + database + " -o " + page);
    EXPECT_EQ(outcome.code, 0) << outcome.output;
    const std::string text = read_file(page);
    return text.substr(0, text.find("</footer>"));  // the chart library's own text comes behind
  }
  nlohmann::json list(const std::string& database, const std::string& more = "") const {
    return nlohmann::json::parse(sweep(database, "--list --json " + more).output).at("points");
  }

  static Texts keys(const std::vector<ReportedPoint>& points) {
    Texts keys;
    for (const ReportedPoint& p : points) keys.push_back(p.key);
    return keys;
  }
  static std::set<std::string> labels(const SweepResults& sweep) {
    std::set<std::string> labels;
    for (const auto* points : {&sweep.points, &sweep.earlier}) {
      for (const ReportedPoint& p : *points) {
        labels.insert(p.machine + " " + p.mode + " " + p.scene + " " + p.design + " " + p.coordinates.dump());
      }
    }
    return labels;
  }
  /// "#5 3.1": the largest speed-up of the first view, over the point that the report takes.
  static double largest_speedup(const SweepResults& sweep) {
    const SweepViews shown(sweep);
    double largest = 0.0;
    for (const ShownPoint& p : shown.points()) {
      if (p.view == 0) largest = std::max(largest, shown.speedup(p, shown.reference()));
    }
    return largest;
  }
};

class EditedKey : public EditedPlan, public testing::WithParamInterface<Edit> {};

/// After an edit of what no axis varies the report took the speed-up over the old baseline, which had the same name.
TEST_P(EditedKey, OldPointsAreToldApartFromNewOnes) {
  const Edit& edit = GetParam();
  write(edit.before);
  fill("a.sqlite");
  const Texts old = keys(results("a.sqlite").points);
  write(edit.after);
  const auto listed = list("a.sqlite");
  fill("a.sqlite");
  fill("fresh.sqlite");
  const SweepResults both = results("a.sqlite"), fresh = results("fresh.sqlite");
  ASSERT_EQ(both.points.size(), fresh.points.size());
  EXPECT_EQ(keys(both.points), keys(fresh.points));
  EXPECT_EQ(keys(both.earlier), old);
  EXPECT_EQ(labels(both).size(), both.points.size() + both.earlier.size());
  for (const ReportedPoint& p : both.points) EXPECT_TRUE(p.coordinates.contains(edit.differs)) << p.coordinates;
  EXPECT_EQ(largest_speedup(both), largest_speedup(fresh));
  EXPECT_THAT(compare("a.sqlite", "fresh.sqlite"),
              AllOf(HasSubstr("the same results"), HasSubstr("a.sqlite: 4 points of an earlier plan take no part")));
  EXPECT_THAT(report("a.sqlite"), AllOf(HasSubstr("4 points of an earlier plan"), HasSubstr("<dd>4 / 4</dd>")));
  // The list says so before a point of the new plan has run.
  std::set<std::string> names;
  Texts earlier;
  for (const auto& p : listed) {
    names.insert(p.at("design").dump() + p.at("coordinates").dump());
    if (p.at("earlier_plan").get<bool>()) earlier.push_back(p.at("key"));
    EXPECT_EQ(p.at("status"), p.at("earlier_plan").get<bool>() ? "done" : "new");
  }
  EXPECT_EQ(names.size(), 8U);
  EXPECT_EQ(earlier, old);
}

INSTANTIATE_TEST_SUITE_P(
    Of, EditedKey,
    testing::Values(Edit{"width", "width = 8\nheight = 8", "width = 16\nheight = 8", "width"},
                    Edit{"view", "width = 8\nheight = 8\nview = 0", "width = 8\nheight = 8\nview = 1", "view"},
                    Edit{"fov_scale", "width = 8\nheight = 8", "width = 8\nheight = 8\nfov_scale = 0.5", "fov_scale"},
                    Edit{"scene", "name = 's'\nwidth = 8\nheight = 8",
                         "sh_degree = 1\nname = 's'\nwidth = 8\nheight = 8", "sh_degree"},
                    Edit{"gpu_sms", "width = 8\nheight = 8\n[set]\ngpu.sms = 1",
                         "width = 8\nheight = 8\n[set]\ngpu.sms = 2", "gpu.sms"},
                    Edit{"tracer_ert", "width = 8\nheight = 8\n[tracer]\nert = 0.01",
                         "width = 8\nheight = 8\n[tracer]\nert = 0.5", "tracer.ert"},
                    Edit{"mirror", "width = 8\nheight = 8", "width = 8\nheight = 8\n[tracer]\nsecondary = 'mirror'",
                         "tracer.secondary"}),
    [](const auto& instance) { return instance.param.name; });

TEST_F(EditedPlan, PointsAreInAllViewsAlsoOnceTheLatencyIsEdited) {
  const std::string scene = "width = 8\nheight = 8\nviews = [0, 1]\n[set]\nl2.latency = ";
  write(scene + "100");
  fill("a.sqlite");
  write(scene + "300");
  fill("a.sqlite");
  const SweepResults sweep = results("a.sqlite");
  const SweepViews shown(sweep);
  EXPECT_EQ(sweep.points.size(), 8U);
  EXPECT_EQ(sweep.earlier.size(), 8U);
  EXPECT_TRUE(shown.views().front().is_mean());
}

TEST_F(EditedPlan, FreePointsOfPaperAreNoPointsOfAChargedPlan) {
  write("width = 8\nheight = 8");
  fill("a.sqlite", "--machine paper");
  fill("a.sqlite", "--machine paper-charged");
  const SweepResults sweep = results("a.sqlite");
  ASSERT_EQ(sweep.points.size(), 4U);
  ASSERT_EQ(sweep.earlier.size(), 4U);
  for (const ReportedPoint& p : sweep.points) EXPECT_EQ(p.machine, "paper-charged");
  for (const ReportedPoint& p : sweep.earlier) EXPECT_EQ(p.machine, "paper");
  EXPECT_EQ(sweep.meta.at("machine"), "paper-charged");
  const Outcome listed = this->sweep("a.sqlite", "--list --machine paper-charged");
  EXPECT_THAT(listed.output, AllOf(HasSubstr("done     paper-charged cycle object-300-7 grtx\n"),
                                   HasSubstr("done     paper cycle object-300-7 grtx (of an earlier plan)\n"),
                                   HasSubstr("4 points, 2 traces; 4 of an earlier plan\n")));
}

/// All were "paper, changed": the simulation was not told the machine.
TEST_F(EditedPlan, ChargedPointsSayTheirOwnMachine) {
  write("width = 8\nheight = 8");
  fill("a.sqlite", "--machine paper-charged");
  EXPECT_THAT(rows("a.sqlite",
                   "SELECT DISTINCT json_extract(config, '$.\"rt.warp_buffer.entries\"') || ' ' || "
                   "json_extract(document, '$.inputs.machine') FROM point ORDER BY 1"),
              ElementsAre("4 paper-charged, changed", "8 paper-charged"));
  // A file of one's own is called by its name, from whatever folder.
  write_file(folder + "/own.toml", "include = \"" + grtx::paths::source_dir() +
                                       "/configs/machines/paper-charged.toml\"\n[rt.warp_buffer]\nentries = 4\n");
  fill("b.sqlite", "--machine " + folder + "/own.toml");
  EXPECT_THAT(rows("b.sqlite",
                   "SELECT DISTINCT machine || ': ' || json_extract(config, '$.\"rt.warp_buffer.entries\"') || ' ' || "
                   "json_extract(document, '$.inputs.machine') FROM point ORDER BY 1"),
              ElementsAre("own: 4 own", "own: 8 own, changed"));
}

TEST_F(EditedPlan, BackToTheFirstPlanItsPointsAreOfThePlanAgain) {
  write("width = 8\nheight = 8");
  fill("a.sqlite");
  fill("fresh.sqlite");
  write("width = 16\nheight = 8");
  fill("a.sqlite");
  write("width = 8\nheight = 8");
  const Outcome again = sweep("a.sqlite", "--program " + program("[ $# -gt 4 ] && exit 9"));
  EXPECT_EQ(again.code, 0) << again.output;
  EXPECT_THAT(again.output, HasSubstr("4 points: 4 done; " + folder + "/a.sqlite\n" + folder +
                                      "/a.sqlite: 4 points of an earlier plan take no part\n"));
  EXPECT_EQ(keys(results("a.sqlite").points), keys(results("fresh.sqlite").points));
  EXPECT_THAT(compare("a.sqlite", "fresh.sqlite"), HasSubstr("the same results"));
}

/// Modes are kept apart wherever points are compared, and a mode is compared with another.
TEST_F(EditedPlan, ThePointsOfAnotherModeAreOfThePlan) {
  write("width = 8\nheight = 8");
  fill("a.sqlite", "--mode cycle");
  fill("a.sqlite", "--mode windows");
  EXPECT_EQ(results("a.sqlite").points.size(), 8U);
  EXPECT_TRUE(results("a.sqlite").earlier.empty());
  write("width = 16\nheight = 8");
  fill("a.sqlite", "--mode windows");
  EXPECT_EQ(results("a.sqlite").points.size(), 4U);
  EXPECT_EQ(results("a.sqlite").earlier.size(), 8U);
}

/// An axis that an earlier plan did not have was missing in the name of the points that both have.
TEST_F(EditedPlan, APointOfBothPlansIsCalledAsTheLastOneCallsIt) {
  write("width = 8\nheight = 8");
  fill("a.sqlite");
  write("width = 8\nheight = 8", "l1.latency = [20, 30]\n");
  fill("a.sqlite");
  for (const ReportedPoint& p : results("a.sqlite").points) EXPECT_TRUE(p.coordinates.contains("l1.latency"));
  EXPECT_TRUE(results("a.sqlite").earlier.empty());
}

TEST_F(EditedPlan, RetryLeavesTheReasonsOfAnEarlierPlan) {
  write("width = 8\nheight = 8");
  EXPECT_EQ(sweep("a.sqlite", "--program " + program("if [ $1 = sim ] && [ $# -gt 4 ]; then echo 'grtx: no luck' >&2; "
                                                     "exit 3; fi"))
                .code,
            1);
  write("width = 16\nheight = 8");
  fill("a.sqlite", "--retry");
  EXPECT_EQ(rows("a.sqlite", "SELECT status, reason, count(*) FROM point GROUP BY status", 3),
            (Texts{"done||4", "failed|sim: no luck|4"}));
  write("width = 8\nheight = 8");
  fill("a.sqlite", "--retry");
  EXPECT_EQ(rows("a.sqlite", "SELECT status, count(*) FROM point GROUP BY status", 2), (Texts{"done|8"}));
}

class EditedSearch : public EditedPlan {
 protected:
  EditedSearch() { command = "search"; }
};

TEST_F(EditedSearch, TheResultOfAnEarlierSearchIsShownWithTheNewPoints) {
  write_file(folder + "/plan.toml",
             "[[scene]]\npreset = 'object'\ncount = 300\nseed = 7\nwidth = 8\nheight = 8\n"
             "[[parameter]]\nkey = 'rt.warp_buffer.entries'\nvalues = [4, 8]\n"
             "[[objective]]\nvalue = 'gpu.time_us'\n[reference]\nrt.warp_buffer.entries = 8\n"
             "[search]\npopulation = 8\ncandidates = 2\nconfirm = 'cycle'\n");
  fill("a.sqlite", "--machine paper");
  fill("a.sqlite", "--machine paper-charged");
  const SweepResults search = results("a.sqlite");
  EXPECT_EQ(search.search.at("machine"), "paper-charged");
  EXPECT_EQ(search.points.size(), search.earlier.size());
  for (const ReportedPoint& p : search.points) EXPECT_EQ(p.machine, "paper-charged");
  command = "sweep";
  write("width = 16\nheight = 8");
  fill("a.sqlite");
  EXPECT_TRUE(results("a.sqlite").search.is_null());
  EXPECT_EQ(results("a.sqlite").points.size(), 4U);
}

}  // namespace
}  // namespace grtx::report
