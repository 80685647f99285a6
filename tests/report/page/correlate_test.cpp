// SPDX-License-Identifier: Apache-2.0
// Measured figures against a small database: pairs of scenes, means where scenes differ, and what is wrong in a file.
#include "grtx/report/page/correlate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "error_of.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "paths.h"
#include "sweep_database.h"
#include "temporary_folder.h"

namespace grtx::report {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

class Correlate : public ::testing::Test {
 protected:
  std::string file(const char* name) const { return folder_.path(name); }
  std::string csv(const std::string& text) const { return folder_.write("measured.csv", text); }
  /// Times of baseline and sw on two scenes: speed-ups 2 and 1.5.
  SweepResults database() const {
    const std::string path = file("sweep.sqlite");
    std::filesystem::remove(path);
    const auto point = [](int id, const char* scene, const char* design, double time, int degree = 2) {
      return json{{"id", id},
                  {"scene", scene},
                  {"design", design},
                  {"coordinates", {{"tracer.kernel_degree", degree}}},
                  {"values", {{"gpu.time_us", time}}}};
    };
    testing_sweep::make_points(
        path, {point(1, "room", "baseline", 100), point(2, "room", "sw", 50), point(3, "garden", "baseline", 300),
               point(4, "garden", "sw", 200), point(5, "garden", "sw", 250, 4)});
    return read_sweep_results(path);
  }
  const grtx::test::TemporaryFolder folder_;
  std::string fault_of(const std::string& text) const {
    return grtx::test::error_of([&] { correlate(read_measured(csv(text)), database(), "sweep.sqlite"); });
  }
};

TEST_F(Correlate, ScenesOfTheSameNameAreComparedOneByOne) {
  const Correlation c = correlate(read_measured(csv("scene,design,over,tracer.kernel_degree,value,low,high\n"
                                                    "room,tlas-tri20,tri20,2,1.6,1.5,1.7\n"
                                                    "garden,sw,baseline,2,1.5,,\n")),
                                  database(), "sweep.sqlite");
  ASSERT_EQ(c.comparisons.size(), 2u);
  EXPECT_EQ(c.comparisons[0].label, "room: sw over baseline, tracer.kernel_degree 2");
  EXPECT_TRUE(c.comparisons[0].paired);
  EXPECT_DOUBLE_EQ(c.comparisons[0].simulated, 2.0);
  EXPECT_FALSE(c.comparisons[0].inside());
  EXPECT_TRUE(c.comparisons[1].inside());
  EXPECT_STREQ(c.comparisons[0].inside_words(), "no");
  EXPECT_STREQ(c.comparisons[1].inside_words(), "no range");  // a figure without low and high was "no", whatever it was
  EXPECT_DOUBLE_EQ(c.mean_error, 0.25 / 2);
  EXPECT_DOUBLE_EQ(c.factor, std::sqrt(1.25));
  EXPECT_DOUBLE_EQ(c.spearman, 1.0);
  EXPECT_DOUBLE_EQ(c.kendall, 1.0);
}

TEST_F(Correlate, OtherScenesAreComparedByMeansAndRanges) {
  const Correlation c = correlate(read_measured(csv("scene,design,over,tracer.kernel_degree,value\n"
                                                    "bicycle,sw,baseline,2,1\nstump,sw,baseline,2,4\n")),
                                  database(), "sweep.sqlite");
  ASSERT_EQ(c.comparisons.size(), 1u);
  const Comparison& one = c.comparisons[0];
  EXPECT_FALSE(one.paired);
  EXPECT_EQ(one.measured_scenes, 2u);
  EXPECT_DOUBLE_EQ(one.measured, 2.0);
  EXPECT_DOUBLE_EQ(one.measured_high, 4.0);
  EXPECT_DOUBLE_EQ(one.simulated, std::sqrt(3.0));
  EXPECT_DOUBLE_EQ(one.simulated_low, 1.5);
  EXPECT_TRUE(one.inside());
  EXPECT_TRUE(std::isnan(c.spearman));
  EXPECT_THAT(correlation_text(c), HasSubstr("rank correlation: none"));
}

// Times in µs and speed-ups were ranked as one list: Spearman 1.00.
TEST_F(Correlate, TimesAndSpeedUpsHaveNoRankTogether) {
  const Correlation c = correlate(read_measured(csv("scene,design,over,tracer.kernel_degree,value\n"
                                                    "room,sw,,2,60\ngarden,sw,,2,190\nroom,sw,baseline,2,1.6\n")),
                                  database(), "sweep.sqlite");
  ASSERT_EQ(c.comparisons.size(), 3u);
  EXPECT_TRUE(std::isnan(c.spearman));
  EXPECT_TRUE(std::isnan(c.kendall));
  EXPECT_THAT(correlation_text(c), HasSubstr("rank correlation: none, the figures are of several quantities"));
  EXPECT_TRUE(correlation_json(c).at("kendall").is_null());
}

TEST_F(Correlate, WhatStandsOutIsNamed) {
  const std::string path = file("many.sqlite");
  std::filesystem::remove(path);
  json points = json::array();
  std::string text = "scene,design,value\n";
  for (int i = 1; i <= 6; ++i) {
    points.push_back({{"id", i},
                      {"scene", "s" + std::to_string(i)},
                      {"design", "sw"},
                      {"values", {{"gpu.time_us", (i == 4 ? 60.0 : 20.0) * i}}}});
    text += "s" + std::to_string(i) + ",sw," + std::to_string(10 * i) + "\n";
  }
  testing_sweep::make_points(path, points);
  const SweepResults sweep = read_sweep_results(path);
  const Correlation c = correlate(read_measured(csv(text)), sweep, path);
  EXPECT_EQ(c.outliers, std::vector<std::string>{"s4: sw"});
  const std::string page = correlation_page(c, "m<1>.csv", sweep);
  EXPECT_THAT(page, HasSubstr("s4: sw"));
  EXPECT_THAT(page, HasSubstr("m&lt;1&gt;.csv"));
  EXPECT_EQ(page.find("m<1>"), std::string::npos);
}

TEST_F(Correlate, HeadlineFiguresStandInARowAndPointsHaveTheNumbersOfTheTable) {
  const SweepResults sweep = database();
  const std::string page = correlation_page(
      correlate(read_measured(csv("scene,design,over,tracer.kernel_degree,value\nroom,sw,baseline,2,1.6\n"
                                  "garden,sw,baseline,2,1.4\n")),
                sweep, "sweep.sqlite"),
      "measured.csv", sweep);
  const std::size_t row = page.find("<dl class=\"cards\">"), end = page.find("</dl>", row);
  ASSERT_NE(row, std::string::npos);
  for (const char* card : {"mean error", "common factor", "Spearman"}) {
    const std::size_t place = page.find("<dt>" + std::string(card));
    EXPECT_TRUE(row < place && place < end) << card;
  }
  EXPECT_THAT(page, HasSubstr("2. garden: sw over baseline"));
  EXPECT_THAT(page, HasSubstr("\"number\":2"));
}

TEST_F(Correlate, ACropStandsForTheFrameOfTheCardWithoutTheTailThatAFrameHasNot) {
  const std::string path = file("crop.sqlite");
  std::filesystem::remove(path);
  const auto point = [](int id, const char* design, double cycles, double occupancy) {
    return json{{"id", id},
                {"scene", "room"},
                {"design", design},
                {"config", {{"gpu.sms", 2}, {"rt.warp_buffer.entries", 8}}},
                {"values", {{"gpu.cycles", cycles}, {"gpu.rt.occupancy", occupancy}}}};
  };
  testing_sweep::make_points(path, {point(1, "baseline", 1e6, 4.0), point(2, "sw", 1e6, 2.0)});
  testing_sweep::execute(
      path, R"(INSERT INTO trace VALUES('t', 'room', '{"width": 48, "height": 48}', '', 0, 'done', '', 0))");
  const Correlation c = correlate(read_measured(csv("scene,design,over,quantity,pixels,sms,mhz,value\n"
                                                    "room,baseline,,frame.ms,23040,4,1000,2\n"
                                                    "room,sw,baseline,frame.ms,,,,1\n")),
                                  read_sweep_results(path), path);
  ASSERT_EQ(c.comparisons.size(), 2u);
  EXPECT_DOUBLE_EQ(c.comparisons[0].simulated, 0.5 * 1e6 * 10 * 2 / 4 / 1e6);  // half full, ten crops, half of the SMs
  EXPECT_DOUBLE_EQ(c.comparisons[1].simulated, 2.0);
  EXPECT_THAT(fault_of("design,quantity,value\nsw,frame.ms,1\n"),
              HasSubstr("line 2: frame.ms needs pixels, sms and mhz"));
}

TEST_F(Correlate, APlanMaySetForAllOfItsPointsWhatAFigureNames) {
  const std::string path = file("rounds.sqlite");
  std::filesystem::remove(path);
  const json point = {
      {"id", 1}, {"scene", "room"}, {"design", "sw"}, {"config", {{"gpu.sms", 2}}}, {"values", {{"gpu.time_us", 50}}}};
  testing_sweep::make_points(path, json::array({point}));
  testing_sweep::execute(path,
                         R"(INSERT INTO trace VALUES('t', 'room', '{"tracer": {"k": "18"}}', '', 0, 'done', '', 0))");
  const Correlation c = correlate(read_measured(csv("source,scene,design,tracer.k,gpu.sms,value\n"
                                                    "chart,room,sw,18,2,40\nother,room,sw,16,2,40\n"
                                                    "larger,room,sw,18,4,40\n")),
                                  read_sweep_results(path), path);
  ASSERT_EQ(c.comparisons.size(), 1u);
  EXPECT_EQ(c.comparisons.front().label, "room: chart: sw, tracer.k 18, gpu.sms 2");
  EXPECT_EQ(c.unmatched.size(), 2u);
}

TEST_F(Correlate, FiguresOfOneCardAreComparedAndWhatKeepsOthersFromItIsSaid) {
  const std::vector<Measured> all =
      read_measured(csv("card,source,design,why,value\nA 1,chart,baseline,,100\n"
                        "A 1,chart,3dgs,a rasteriser,1\nB 2,,sw,,7\n"));
  const auto card_fault = [&](const char* card) { return grtx::test::error_of([&] { of_card(all, card, "m.csv"); }); };
  EXPECT_THAT(card_fault(""), HasSubstr("line 4: is of another card"));
  EXPECT_THAT(card_fault("C"), HasSubstr("card C: is none of A 1, B 2"));
  const std::vector<Measured> one = of_card(all, "A 1", "m.csv");
  ASSERT_EQ(one.size(), 2u);
  const Correlation c = correlate(one, database(), "sweep.sqlite");
  EXPECT_EQ(c.comparisons.front().label, "chart: baseline");
  EXPECT_EQ(c.unmatched, std::vector<std::string>{"chart: 3dgs (a rasteriser)"});
}

TEST_F(Correlate, AMeanHasTheStandardErrorOfItsScenesAndOneSceneNone) {
  const Correlation c = correlate(read_measured(csv("scene,design,over,tracer.kernel_degree,value\n"
                                                    "bicycle,sw,baseline,2,1\nstump,sw,baseline,2,4\n")),
                                  database(), "sweep.sqlite");
  const Comparison& one = c.comparisons.front();  // measured 1 and 4, simulated 2 and 1.5
  const double error = std::hypot(std::log(4.0), std::log(2.0 / 1.5)) / 2.0;
  EXPECT_DOUBLE_EQ(one.standard_error, error);
  EXPECT_DOUBLE_EQ(one.deviations(), std::log(std::sqrt(3.0) / 2.0) / error);
  EXPECT_TRUE(std::isnan(Comparison{}.deviations()));
}

TEST(SpearmanRho, OfRanksByHand) {
  EXPECT_DOUBLE_EQ(spearman_rho({1, 2, 3, 4}, {10, 100, 1000, 10000}), 1.0);
  EXPECT_DOUBLE_EQ(spearman_rho({1, 2, 3}, {3, 2, 1}), -1.0);
  EXPECT_DOUBLE_EQ(spearman_rho({1, 2, 3, 4}, {1, 2, 4, 3}), 1.0 - 6.0 * 2.0 / (4 * 15));
  EXPECT_DOUBLE_EQ(spearman_rho({1, 1, 2}, {1, 2, 3}), 1.5 / std::sqrt(1.5 * 2.0));  // ranks 0.5, 0.5, 2
  EXPECT_TRUE(std::isnan(spearman_rho({1, 1}, {1, 2})));
}

TEST_F(Correlate, AFaultIsNamedWithItsLine) {
  struct Case {
    const char* text;
    const char* says;
  };
  for (const Case& c : {Case{"scene,design\nroom,sw\n", "line 1: column 'value' is missing"},
                        Case{"design,valu\nsw,1\n", "line 1: column 'valu' is none of"},
                        Case{"design,value,value\nsw,1,1\n", "is there twice"},
                        Case{"# comment\ndesign,value\nsw\n", "line 3: has 1 fields in place of 2"},
                        Case{"design,value\nsw,fast\n", "line 2: value 'fast' must be a number above 0"},
                        Case{"design,value\nsw,-1\n", "must be a number above 0"},
                        Case{"design,value,low,high\nsw,1,2,3\n", "value must lie between low and high"},
                        Case{"design,value\n", "holds no measured figure"},
                        Case{"design,value\nhw,1\n", "no point that a measured figure fits: first of them hw"},
                        Case{"design,value\nsw,1\n", "scene garden: has several points of sw that line 2 fits"}}) {
    EXPECT_THAT(fault_of(c.text), HasSubstr(c.says)) << c.text;
  }
}

TEST_F(Correlate, TheProjectsOwnFilesAreRead) {
  for (const auto& entry : std::filesystem::directory_iterator(grtx::paths::source_dir() + "/data/measured")) {
    EXPECT_FALSE(read_measured(entry.path().string()).empty()) << entry.path();
  }
}

}  // namespace
}  // namespace grtx::report
