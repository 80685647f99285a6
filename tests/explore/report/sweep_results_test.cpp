// What a report reads from a sweep database.
#include "grtx/explore/report/sweep_results.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "grtx/explore/report/sections.h"
#include "sweep_database.h"

namespace grtx::sim {
namespace {

class SweepResultsTest : public testing::Test {
 protected:
  SweepResultsTest() : path(testing::TempDir() + "/grtx_sweep_" + std::to_string(::getpid()) + ".sqlite") {
    std::filesystem::remove(path);
  }
  ~SweepResultsTest() override { std::filesystem::remove(path); }
  std::string path;
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

TEST_F(SweepResultsTest, FrontsAreOfAScene) {
  // Room: the second is worse in both. Hall: slower than either, and alone.
  testing_sweep::make_points(path, nlohmann::json::parse(R"([
    {"id": 1, "scene": "room", "values": {"gpu.time_us": 1, "cost.mm2": 3, "gpu.energy_nj_per_ray": 9}},
    {"id": 2, "scene": "room", "values": {"gpu.time_us": 2, "cost.mm2": 4, "gpu.energy_nj_per_ray": 8}},
    {"id": 3, "scene": "hall", "values": {"gpu.time_us": 9, "cost.mm2": 9}},
    {"id": 4, "scene": "room", "status": "failed"}])"));
  const Fronts front = fronts(read_sweep_results(path));
  EXPECT_EQ(front.area, (std::vector<bool>{true, false, true, false}));
  EXPECT_EQ(front.energy, (std::vector<bool>{true, true, false, false}));
}

}  // namespace
}  // namespace grtx::sim
