// SPDX-License-Identifier: Apache-2.0
// What points of a sweep are compared with, and what they are averaged with.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "grtx/report/page/sections.h"
#include "grtx/report/page/sweep_views.h"

namespace grtx::report {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

ReportedPoint point(std::int64_t id, const char* machine, const char* design, int bytes, double time,
                    const char* scene = "room") {
  ReportedPoint p;
  p.id = id;
  p.machine = machine;
  p.mode = "cycle";
  p.scene = scene;
  p.design = design;
  p.coordinates = {{"l1.bytes", bytes}};
  p.status = "done";
  p.values = {{kTime, time}, {kArea, 1.0}, {kEnergy, 1.0}, {"gpu.cycles", 2.0 * time}};
  return p;
}

ReportSweep sweep_of(std::vector<ReportedPoint> points) {
  ReportSweep sweep;
  sweep.id = "sweep1";
  sweep.results.file = "s.sqlite";
  sweep.results.meta["model_version"] = "7";
  sweep.results.coordinates = {"l1.bytes"};
  sweep.results.points = std::move(points);
  return sweep;
}

// The largest was that of the fastest point over the first baseline, whatever its keys: 5.00 here.
TEST(SweepSpeedUps, TheLargestIsOverABaselineOfTheSameKeys) {
  const ReportSweep sweep = sweep_of({point(1, "paper", "baseline", 32, 1000), point(2, "paper", "baseline", 64, 700),
                                      point(3, "paper", "grtx", 32, 250), point(4, "paper", "grtx", 64, 200)});
  EXPECT_THAT(sweep_headline(sweep),
              AllOf(HasSubstr("<dd>4.00×</dd>"), Not(HasSubstr("5.00×")),
                    HasSubstr("#3 grtx, l1.bytes = 32 over #1 baseline, l1.bytes = 32, the same keys")));
  const SweepViews shown(sweep.results);
  EXPECT_DOUBLE_EQ(shown.speedup(shown.points()[3], shown.reference()), 3.5);                  // 700 / 200
  EXPECT_TRUE(std::isnan(shown.speedup(shown.points()[3], {"", shown.points()[0].machine})));  // two things at once
  EXPECT_DOUBLE_EQ(shown.speedup(shown.points()[3], {"", shown.points()[2].machine}), 1.25);   // keys of one design
}

// Points of paper-charged were over the baseline of paper.
TEST(SweepSpeedUps, PointsOfTwoMachinesAreNotCompared) {
  const ReportSweep sweep = sweep_of({point(1, "paper", "baseline", 32, 1000),
                                      point(2, "paper-charged", "grtx", 32, 100), point(3, "paper", "grtx", 32, 500)});
  const SweepViews shown(sweep.results);
  EXPECT_TRUE(std::isnan(shown.speedup(shown.points()[1], shown.reference())));
  EXPECT_DOUBLE_EQ(shown.speedup(shown.points()[2], shown.reference()), 2.0);
  EXPECT_THAT(sweep_headline(sweep), AllOf(HasSubstr("machines paper and paper-charged, mode cycle, model version 7"),
                                           HasSubstr("#2 paper-charged, grtx")));
}

// An edited plan changes keys that are no coordinates: the configuration and the inputs tell.
TEST(SweepSpeedUps, PointsOfAnEditedPlanAreNotCompared) {
  std::vector<ReportedPoint> points = {point(1, "", "baseline", 32, 1000), point(2, "", "grtx", 32, 100),
                                       point(3, "", "grtx", 32, 500)};
  points[1].config = {{"gpu.sms", 4}};
  points[0].inputs = points[1].inputs = points[2].inputs = {{"width", "16"}, {"height", "16"}};
  points[2].inputs["width"] = "32";
  const ReportSweep sweep = sweep_of(points);
  const SweepViews shown(sweep.results);
  for (const std::size_t i : {1, 2}) EXPECT_TRUE(std::isnan(shown.speedup(shown.points()[i], shown.reference()))) << i;
  EXPECT_THAT(sweep_headline(sweep), Not(HasSubstr("Largest speed-up")));
}

// The answer of a sweep was a table without a word, and points of an earlier plan were not named in it.
TEST(SweepAnswer, BeginsWithASentenceAndSaysWhatIsLeftOut) {
  std::vector<ReportedPoint> points = {point(1, "", "baseline", 32, 1000), point(2, "", "grtx", 32, 100)};
  points[1].values[kArea] = 1.5;
  ReportSweep sweep = sweep_of(points);
  sweep.results.earlier = {point(3, "", "grtx", 64, 50)};
  EXPECT_THAT(sweep_headline(sweep), AllOf(HasSubstr("is fastest: 10.00 times as fast as #1"),
                                           HasSubstr("the smallest, for 50.0 % more area of the chip."),
                                           HasSubstr("1 of an earlier plan left out")));
}

// The answer called #2 the smallest, the card below it #1, which is as small and slower.
TEST(SweepAnswer, OfEquallySmallPointsTheCardNamesTheOneOfTheAnswer) {
  const ReportSweep sweep = sweep_of({point(1, "", "grtx", 32, 1000), point(2, "", "grtx", 64, 700)});
  EXPECT_THAT(sweep_headline(sweep),
              AllOf(HasSubstr("least area #2"), HasSubstr("<dt>Least area of the chip</dt><dd>1 mm²</dd>"
                                                          "<dd class=\"note\">#2 ")));
}

// Points of gautracer had no speed-up: it brings an option and keys with it, and these were a difference.
TEST(SweepSpeedUps, WhatADesignBringsWithItIsNoDifference) {
  std::vector<ReportedPoint> points = {point(1, "paper", "baseline", 32, 1000),
                                       point(2, "paper", "gautracer", 32, 100)};
  points[0].inputs = {{"k", "8"}, {"sort_key", "entry"}};
  points[1].inputs = {{"k", "16"}, {"sort_key", "peak"}};
  points[0].config = {{"rt.gaussian.enabled", false}, {"l1.bytes", 32}};
  points[1].config = {{"rt.gaussian.enabled", true}, {"l1.bytes", 32}};
  const ReportSweep sweep = sweep_of(points);
  const SweepViews shown(sweep.results);
  EXPECT_DOUBLE_EQ(shown.speedup(shown.points()[1], shown.reference()), 10.0);
}

// Medians were over baseline and grtx together: 600 for 32, 450 for 64.
TEST(SweepEffects, AreOfOneDesign) {
  const ReportSweep sweep = sweep_of({point(1, "paper", "baseline", 32, 1000), point(2, "paper", "baseline", 64, 700),
                                      point(3, "paper", "grtx", 32, 200), point(4, "paper", "grtx", 64, 200)});
  const std::string html = sweep_section(sweep);
  const auto row = [](const char* design, const char* bytes, const char* time) {
    return std::string("<tr><th scope=\"row\">paper, ") + design + "</th><td>l1.bytes</td><td class=\"n\">" + bytes +
           "</td><td class=\"n\">1</td><td class=\"n\">" + time + "</td><td class=\"n\">" + time + "</td>";
  };
  EXPECT_THAT(html, AllOf(HasSubstr(row("baseline", "32", "1,000")), HasSubstr(row("baseline", "64", "700")),
                          HasSubstr(row("grtx", "32", "200")), Not(HasSubstr(">600<"))));
}

TEST(SweepMeans, AreOfOneMachine) {
  const ReportSweep sweep = sweep_of({point(1, "paper", "grtx", 32, 100), point(2, "modern", "grtx", 32, 400, "hall"),
                                      point(3, "paper", "grtx", 32, 900, "hall")});
  const SweepViews shown(sweep.results);
  ASSERT_TRUE(shown.views().front().is_mean());
  ASSERT_EQ(shown.points().size(), 4u);
  EXPECT_DOUBLE_EQ(shown.value(shown.points()[0], kTime), 300.0);  // of #1 and #3
}

TEST(SweepNotes, StandWithThePointsAndInTheHeadline) {
  std::vector<ReportedPoint> points = {point(1, "paper", "grtx", 32, 100), point(2, "paper", "grtx", 64, 90)};
  points[1].notes = {{"partial-launch", "a launch of 8 warps"}};
  const ReportSweep sweep = sweep_of(points);
  EXPECT_THAT(sweep_headline(sweep), HasSubstr("partial-launch: 1 of 2 points; #2"));
  EXPECT_THAT(sweep_section(sweep), AllOf(HasSubstr("<td>partial-launch</td></tr>"), HasSubstr(">mind</th>")));
}

TEST(SweepIntervals, StandWithTheTime) {
  std::vector<ReportedPoint> points = {point(1, "paper", "baseline", 32, 100), point(2, "paper", "grtx", 32, 50)};
  for (ReportedPoint& p : points) {
    const double cycles = p.value("gpu.cycles");
    p.values["gpu.windows.cycles_low"] = 0.8 * cycles;
    p.values["gpu.windows.cycles_high"] = 1.25 * cycles;
  }
  const ReportSweep sweep = sweep_of(points);
  EXPECT_THAT(sweep_headline(sweep), AllOf(HasSubstr("50 µs <span class=\"interval\">(40 to 62.5)</span>"),
                                           HasSubstr("2.00× <span class=\"interval\">(1.28× to 3.12×)</span>")));
}

}  // namespace
}  // namespace grtx::report
