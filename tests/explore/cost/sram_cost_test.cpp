// SPDX-License-Identifier: Apache-2.0
// Memories: the table's own points come back, sizes in between lie between, smaller nodes are smaller.
#include "grtx/explore/cost/sram_cost.h"

#include <gtest/gtest.h>

#include "grtx/explore/cost/technology.h"

namespace grtx::explore {
namespace {

TEST(SramCost, GivesBackThePointsOfTheTable) {
  // 1 KB, 4 B words, one read and one write port, 45 nm.
  const SramCost small = sram_cost({8192, 32, false, true, 45});
  EXPECT_NEAR(small.area_mm2.central, 0.0071, 0.0001);
  EXPECT_NEAR(small.access_ns, 0.23, 0.01);
  EXPECT_NEAR(small.read_pj, 1.35, 0.01);
  EXPECT_NEAR(small.write_pj, 2.1, 0.05);
  EXPECT_NEAR(small.leakage_mw.high, 1.4, 0.05);
  // 128 KB cache, 32 B bus, 45 nm.
  const SramCost cache = sram_cost({128 * 8192, 256, true, false, 45});
  EXPECT_NEAR(cache.area_mm2.central, 0.474, 0.001);
  EXPECT_NEAR(cache.access_ns, 0.937, 0.001);
  EXPECT_NEAR(cache.read_pj, 66.5, 0.1);
}

TEST(SramCost, LiesBetweenTheNeighbouringSizes) {
  const SramCost a = sram_cost({4 * 8192, 256, false, false, 32});
  const SramCost between = sram_cost({5 * 8192, 256, false, false, 32});
  const SramCost b = sram_cost({8 * 8192, 256, false, false, 32});
  EXPECT_LT(a.area_mm2.central, between.area_mm2.central);
  EXPECT_LT(between.area_mm2.central, b.area_mm2.central);
  EXPECT_LT(a.read_pj, between.read_pj);
  EXPECT_LT(between.read_pj, b.read_pj);
}

TEST(SramCost, ShrinksFromNodeToNode) {
  double area = 1e9, read = 1e9;
  for (const unsigned nm : technology_nodes()) {
    const SramCost cost = sram_cost({32 * 8192, 256, false, false, nm});
    EXPECT_LT(cost.area_mm2.low, area) << nm;
    EXPECT_LE(cost.read_pj, read) << nm;
    EXPECT_LE(cost.area_mm2.low, cost.area_mm2.central);
    EXPECT_LE(cost.area_mm2.central, cost.area_mm2.high);
    EXPECT_LE(cost.leakage_mw.low, cost.leakage_mw.high);
    area = cost.area_mm2.central * 1.01;
    read = cost.read_pj;
  }
}

TEST(SramCost, MoreThanTheTableIsBanked) {
  const SramCost largest = sram_cost({4ull * 1024 * 8192, 256, true, false, 22});
  const SramCost twice = sram_cost({8ull * 1024 * 8192, 256, true, false, 22});
  EXPECT_NEAR(twice.area_mm2.central, 2.0 * largest.area_mm2.central, 1e-9);
  EXPECT_NEAR(twice.read_pj, largest.read_pj, 1e-9);
}

}  // namespace
}  // namespace grtx::explore
