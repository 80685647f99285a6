// SPDX-License-Identifier: Apache-2.0
// Where the cycles went: sections from statistics, whatever stalls there are, and their bars.
#include "grtx/rtl_tlm/observe/stall_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "grtx/base/error.h"
#include "rtl_tlm/observe/observed_run.h"

namespace grtx::sim {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::ordered_json;

Json document(const std::vector<std::pair<std::string, double>>& values) {
  Json stats;
  for (const auto& [name, value] : values) stats[name] = {{"value", value}, {"unit", "cycles"}, {"description", ""}};
  return {{"schema", "grtx.stats/1"}, {"config", {{"gpu.sms", 2}, {"rt.box.count", 4}}}, {"stats", stats}};
}

TEST(StallReport, SchedulerCyclesAddUpToAllCycles) {
  const test::ObservedRun run;
  const Json stats = run.run({});
  const auto sections = stall_sections({{"schema", "grtx.stats/1"}, {"stats", stats}}, "s.json");
  ASSERT_GE(sections.size(), 4U);
  EXPECT_EQ(sections[0].whole, 2.0 * static_cast<double>(test::statistic(stats, "gpu.cycles")));  // two SMs
  EXPECT_EQ(sections[0].bars[0].label, "issue");
  EXPECT_EQ(sections[0].bars[0].value, static_cast<double>(test::statistic(stats, "gpu.rt.selections")));
  EXPECT_EQ(sections[1].whole, static_cast<double>(test::statistic(stats, "gpu.simt.resident_warp_cycles")));
}

TEST(StallReport, BarsAreAsLongAsTheirShare) {
  const auto sections = stall_sections(
      document({{"gpu.cycles", 10}, {"gpu.rt.selections", 5}, {"gpu.rt.stall.memory", 10}, {"gpu.rt.stall.unit", 5}}),
      "s.json");
  ASSERT_EQ(sections.size(), 1U);
  const std::string text = stall_text(sections, 8);
  EXPECT_THAT(text, HasSubstr("issue  |##      |  25.0 %             5"));
  EXPECT_THAT(text, HasSubstr("memory |####    |  50.0 %            10"));
}

TEST(StallReport, TakesAnyGroupOfStalls) {
  const auto sections = stall_sections(document({{"gpu.rt.stall.memory", 1},
                                                 {"gpu.rt.stall.warp.unit", 3},
                                                 {"gpu.rt.stall.warp.any_hit", 1},
                                                 {"gpu.sm1.rt.stall.empty", 2}}),
                                       "s.json");
  ASSERT_EQ(sections.size(), 3U);
  EXPECT_EQ(sections[1].title, "gpu.rt.stall.warp");
  EXPECT_EQ(sections[1].whole, 4);
  EXPECT_EQ(sections[2].title, "gpu.sm1.rt.stall");
}

TEST(StallReport, ShowsPipelinesAndBounds) {
  const auto sections = stall_sections(document({{"gpu.cycles", 100},
                                                 {"gpu.rt.stall.memory", 1},
                                                 {"gpu.rt.ray_box.operations", 1},
                                                 {"gpu.rt.ray_box.busy_cycles", 200},
                                                 {"gpu.bound.issue", 50},
                                                 {"gpu.bound.unit.box", 25},
                                                 {"gpu.bound.fraction", 0.5}}),
                                       "s.json");
  ASSERT_EQ(sections.size(), 3U);
  EXPECT_EQ(sections[1].bars[0].value, 25.0);  // 200 of 100 cycles x 4 pipelines x 2 SMs
  ASSERT_EQ(sections[2].bars.size(), 2U);
  EXPECT_EQ(sections[2].bars[1].label, "unit.box");
  EXPECT_EQ(sections[2].whole, 100);
}

// "2.7 %  2.70": a share of pipelines stood there twice.
TEST(StallReport, AFigureInPercentIsPrintedOnce) {
  const std::string text = stall_text(stall_sections(document({{"gpu.cycles", 100},
                                                               {"gpu.rt.stall.memory", 1},
                                                               {"gpu.rt.ray_box.operations", 1},
                                                               {"gpu.rt.ray_box.busy_cycles", 200}}),
                                                     "s.json"),
                                      4);
  EXPECT_THAT(text, HasSubstr("ray_box |#   |  25.0 %\n"));
}

// "one warp is 90 % of the run" and "longest_warp 14.8 %" were two figures of one name.
TEST(StallReport, TheSlowestCallAndTheWorkOfTheLongestWarpAreNamedApart) {
  const std::string text = stall_text(stall_sections(document({{"gpu.cycles", 100},
                                                               {"gpu.rt.stall.memory", 1},
                                                               {"gpu.rt.warp_latency_max", 90},
                                                               {"gpu.bound.longest_warp", 15}}),
                                                     "s.json"),
                                      4);
  EXPECT_THAT(text, HasSubstr("the slowest traceRay call of a warp, with waits (100 cycles)\n"
                              "  slowest_call |####|  90.0 %            90\n"));
  EXPECT_THAT(text, HasSubstr("longest_warp is without waits (100 cycles)\n"
                              "  longest_warp |#   |  15.0 %            15\n"));
}

// "has no statistic named *.stall.*" said nothing to who had simulated windows.
TEST(StallReport, OfWindowsItSaysThatCycleModeHasStalls) {
  Json windows = document({{"gpu.cycles", 1}});
  windows["inputs"]["mode"] = "windows";
  try {
    stall_sections(windows, "s.json");
    ADD_FAILURE() << "was taken";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("are of windows, which have no stalls: simulate with --mode cycle"));
  }
}

TEST(StallReport, RefusesOtherDocuments) {
  for (const Json& wrong : {Json::array(), Json{{"schema", "grtx.run/1"}}, document({{"gpu.cycles", 1}})}) {
    EXPECT_THROW(stall_sections(wrong, "s.json"), Error) << wrong;
  }
}

}  // namespace
}  // namespace grtx::sim
