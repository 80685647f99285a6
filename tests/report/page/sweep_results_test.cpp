// SPDX-License-Identifier: Apache-2.0
// What a report reads from a sweep database.
#include "grtx/report/page/sweep_results.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "grtx/report/page/sweep_answer.h"
#include "grtx/report/page/sweep_views.h"
#include "sweep_database.h"
#include "temporary_folder.h"

namespace grtx::report {
namespace {

class SweepResultsTest : public testing::Test {
 protected:
  const grtx::test::TemporaryFolder folder;
  const std::string path = folder.path("a.sqlite");
};

TEST_F(SweepResultsTest, PointsValuesAndCoordinates) {
  testing_sweep::make_grid(path, "{\"l1.bytes\": 1}");
  ASSERT_TRUE(is_database(path));
  const SweepResults sweep = read_sweep_results(path);
  ASSERT_EQ(sweep.points.size(), 60u);
  EXPECT_EQ(sweep.coordinates,
            (std::vector<std::string>{"rt.warp_buffer.entries", "rt.checkpoint.lanes", "l1.bytes", "k"}));
  const ReportedPoint& first = sweep.points[0];
  EXPECT_EQ(first.id, 1);
  EXPECT_EQ(first.coordinates.at("l1.bytes"), 65536);
  EXPECT_EQ(first.config.at("l1.bytes"), 65536);
  EXPECT_DOUBLE_EQ(first.value("gpu.time_us"), 1000 + 1500 + 300 + 312.5 + 160);
  EXPECT_TRUE(std::isnan(first.value("no.such")));
  EXPECT_EQ(sweep.points[6].status, "failed");
  EXPECT_EQ(sweep.points[30].reason, "longer than 20 s");
  EXPECT_EQ(sweep.traces.size(), 2u);
  EXPECT_FALSE(sweep.several(&ReportedPoint::scene));
  EXPECT_TRUE(sweep.several(&ReportedPoint::status));
}

TEST_F(SweepResultsTest, TheHashIsOfThePointsAndNotOfTheFile) {
  testing_sweep::make_grid(path, "{}");
  const std::string before = read_sweep_results(path).hash;
  testing_sweep::execute(path,
                         "CREATE TABLE filler(a); INSERT INTO filler VALUES (randomblob(9999)); DROP TABLE filler");
  EXPECT_EQ(read_sweep_results(path).hash, before);
  testing_sweep::execute(path, "UPDATE value SET value = value + 1 WHERE point_id = 5 AND name = 'gpu.cycles'");
  testing_sweep::write_documents(path);
  EXPECT_NE(read_sweep_results(path).hash, before);
}

// Two scenes: the front of each, and that of the geometric means of what both have.
TEST_F(SweepResultsTest, PointsOfDifferentScenesShareNoFront) {
  testing_sweep::make_points(path, nlohmann::json::parse(R"([
    {"id": 1, "scene": "room", "coordinates": {"k": 4}, "values": {"gpu.time_us": 1, "cost.mm2": 3, "gpu.energy_nj_per_ray": 9}},
    {"id": 2, "scene": "room", "coordinates": {"k": 8}, "values": {"gpu.time_us": 2, "cost.mm2": 4, "gpu.energy_nj_per_ray": 8}},
    {"id": 3, "scene": "hall", "coordinates": {"k": 4}, "values": {"gpu.time_us": 9, "cost.mm2": 3}},
    {"id": 4, "scene": "hall", "coordinates": {"k": 8}, "status": "failed"},
    {"id": 5, "scene": "hall", "coordinates": {"k": 16}, "values": {"gpu.time_us": 4, "cost.mm2": 9}}])"));
  const SweepResults results = read_sweep_results(path);
  const SweepViews shown(results);
  ASSERT_EQ(shown.views().size(), 3u);
  EXPECT_EQ(shown.views()[0].title, "all 2 views");
  EXPECT_EQ(shown.views()[1].title, "room");
  std::string found;
  for (const ShownPoint& p : shown.points()) {
    found +=
        shown.views()[p.view].title + " " + p.label + (p.on_area ? " mm2" : "") + (p.on_energy ? " nJ" : "") + "\n";
  }
  EXPECT_EQ(found, "all 2 views mean 1 mm2\nroom #1 mm2 nJ\nroom #2 nJ\nhall #3 mm2\nhall #5 mm2\n");
  EXPECT_DOUBLE_EQ(shown.value(shown.points()[0], "gpu.time_us"), 3.0);  // of 1 and 9
  EXPECT_TRUE(std::isnan(shown.value(shown.points()[0], "gpu.energy_nj_per_ray")));
  // Over k = 4, the first point of the first view, in each view.
  EXPECT_DOUBLE_EQ(shown.speedup(shown.points()[2], shown.reference()), 0.5);
  EXPECT_DOUBLE_EQ(shown.speedup(shown.points()[4], shown.reference()), 2.25);
}

// The geometric mean of 0 and 40 % was 0.0 %.
TEST_F(SweepResultsTest, AViewWithoutHitsCountsInTheMeanHitRate) {
  testing_sweep::make_points(path, nlohmann::json::parse(R"([
    {"id": 1, "scene": "room", "values": {"gpu.time_us": 1, "gpu.l1.node.hit_rate": 0.0, "gpu.bound.fraction": 0.2}},
    {"id": 2, "scene": "hall", "values": {"gpu.time_us": 9, "gpu.l1.node.hit_rate": 0.4, "gpu.bound.fraction": 0.8}}])"));
  const SweepResults results = read_sweep_results(path);
  const SweepViews shown(results);
  ASSERT_TRUE(shown.views().front().is_mean());
  EXPECT_DOUBLE_EQ(shown.value(shown.points()[0], "gpu.l1.node.hit_rate"), 0.2);
  EXPECT_DOUBLE_EQ(shown.value(shown.points()[0], "gpu.bound.fraction"), 0.5);
  EXPECT_DOUBLE_EQ(shown.value(shown.points()[0], "gpu.time_us"), 3.0);
}

// Names that end alike were shares, and a share of another name was none.
TEST_F(SweepResultsTest, TheKindOfAStatisticSaysWhetherItIsAShare) {
  testing_sweep::make_points(path, nlohmann::json::parse(R"([
    {"id": 1, "scene": "room", "values":
     {"gpu.time_us": 1, "gpu.rt.simt_efficiency": 0.2, "gpu.l2.read_hit_rate": 0.2, "own.fraction": 1}},
    {"id": 2, "scene": "hall", "values":
     {"gpu.time_us": 9, "gpu.rt.simt_efficiency": 0.8, "gpu.l2.read_hit_rate": 0.8, "own.fraction": 9}}])"));
  const SweepResults results = read_sweep_results(path);
  const SweepViews shown(results);
  EXPECT_DOUBLE_EQ(shown.value(shown.points()[0], "gpu.rt.simt_efficiency"), 0.5);
  EXPECT_DOUBLE_EQ(shown.value(shown.points()[0], "gpu.l2.read_hit_rate"), 0.5);
  EXPECT_DOUBLE_EQ(shown.value(shown.points()[0], "own.fraction"), 3.0);
}

// The column "speed-up" did not say over what: the first point, the baseline, the first machine.
TEST_F(SweepResultsTest, TheAnswerSaysWhatItsSpeedUpsAreOver) {
  const auto ends = [&](const char* second, const char* over) {
    testing_sweep::make_points(path, nlohmann::json::parse(fmt::format(R"([
      {{"id": 1, "scene": "room", "coordinates": {{"k": 4}}, "values": {{"gpu.time_us": 3, "cost.mm2": 3}}}},
      {{"id": 2, "scene": "room", {}, "values": {{"gpu.time_us": 1, "cost.mm2": 4}}}}])",
                                                                       second)));
    const SweepResults results = read_sweep_results(path);
    std::string text = sweep_answer_text(results);
    for (std::size_t at = 0; (at = text.find("\n  ", at)) != std::string::npos;) text.replace(at, 3, " ");
    EXPECT_THAT(text, testing::EndsWith(std::string("; ") + over + "\n"));
    EXPECT_THAT(sweep_answer_html(results), testing::HasSubstr(std::string("; ") + over + ".</p>"));
    std::filesystem::remove(path);
  };
  ends(R"("coordinates": {"k": 8})", "speed-up over #1");
  ends(R"("coordinates": {"k": 4}, "design": "walk")", "speed-up over grtx with the same keys");
  ends(R"("coordinates": {"k": 4}, "machine": "own")", "speed-up over the same on paper");
}

// #1 is slow, with the smallest RT unit on a large chip: the front over the chip's area leaves it out.
TEST_F(SweepResultsTest, TheFrontIsOverEachOfTheTwoAreas) {
  testing_sweep::make_points(path, nlohmann::json::parse(R"([
    {"id": 1, "coordinates": {"k": 4}, "values": {"gpu.time_us": 3, "cost.mm2": 30, "cost.rt_unit_mm2": 0.5}},
    {"id": 2, "coordinates": {"k": 8}, "values": {"gpu.time_us": 2, "cost.mm2": 20, "cost.rt_unit_mm2": 0.75}},
    {"id": 3, "coordinates": {"k": 16}, "values": {"gpu.time_us": 1, "cost.mm2": 40, "cost.rt_unit_mm2": 1}}])"));
  const auto answer = [&] {
    const SweepResults results = read_sweep_results(path);
    EXPECT_THAT(sweep_answer_html(results), testing::HasSubstr(">RT unit, mm²</th>"));
    std::string text = sweep_answer_text(results);
    for (std::size_t at = 0; (at = text.find("\n  ", at)) != std::string::npos;) text.replace(at, 3, " ");
    return text;
  };
  using testing::AllOf, testing::HasSubstr, testing::Not;
  EXPECT_THAT(answer(), AllOf(HasSubstr("\nfront of time against the area of the chip "), HasSubstr("  #3 "),
                              Not(HasSubstr("  #1 ")), HasSubstr("least area #2"),
                              HasSubstr("; over the area of an RT unit (area = \"cost.rt_unit_mm2\" in the plan) the "
                                        "front is #1, #2, #3\n")));
  testing_sweep::execute(path, "INSERT INTO meta VALUES('area', 'cost.rt_unit_mm2')");
  EXPECT_THAT(answer(), AllOf(HasSubstr("\nfront of time against the area of an RT unit "), HasSubstr("  #1 "),
                              HasSubstr("least area #1"),
                              HasSubstr("over the area of the chip (area = \"cost.mm2\" in the plan) "
                                        "the front is #2, #3\n")));
}

TEST_F(SweepResultsTest, APointIsCalledByWhatSetsItApart) {
  nlohmann::json points = nlohmann::json::array();
  for (int id = 1; id <= 8; ++id) {  // one change at a time; view and g never set a point apart
    nlohmann::json coordinates = {{"view", id % 2}, {"g", 7}};
    for (const char* key : {"a", "b", "c", "d", "e", "f"}) coordinates[key] = id > 2 && key[0] - 'a' == id - 3 ? 2 : 1;
    points.push_back({{"id", id}, {"coordinates", coordinates}, {"values", {{"gpu.time_us", id}}}});
  }
  testing_sweep::make_points(path, points);
  const SweepResults results = read_sweep_results(path);
  const SweepViews shown(results);
  EXPECT_EQ(shown.varying(), (std::vector<std::string>{"a", "b", "c", "d", "e", "f"}));
  EXPECT_EQ(shown.name(results.points[0]), "all else as most points have it");
  EXPECT_EQ(shown.name(results.points[3]), "b = 2");
}

}  // namespace
}  // namespace grtx::report
