// SPDX-License-Identifier: Apache-2.0
// Which designs no other beats, in any number of costs: by hand, and against the definition on random points.
#include "grtx/explore/sweep/dominance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

namespace grtx::explore {
namespace {

TEST(Dominance, IsNoWorseInAllAndBetterInOne) {
  EXPECT_TRUE(dominates({1, 2, 3}, {1, 2, 4}));
  EXPECT_FALSE(dominates({1, 2, 3}, {1, 2, 3}));
  EXPECT_FALSE(dominates({1, 2, 5}, {1, 3, 4}));
}

TEST(Front, ByHand) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const struct {
    std::vector<std::vector<double>> points;
    std::vector<bool> front;
  } cases[] = {
      {{}, {}},
      {{{1, 1}}, {true}},
      {{{1, 2}, {2, 1}}, {true, true}},
      {{{1, 1}, {2, 2}}, {true, false}},
      {{{1, 1}, {1, 1}}, {true, true}},   // equals
      {{{1, 2}, {1, 1}}, {false, true}},  // the same first cost
      {{{1, 1}, {2, 1}}, {true, false}},  // the same second cost
      {{{3, 1}, {1, 3}, {2, 2}, {3, 3}}, {true, true, true, false}},
      {{{1, nan}, {2, 2}, {nan, 1}, {}}, {false, true, false, false}},  // what was not measured is on no front
      {{{1, 3}, {2, 2}, {3, 1}, {3, 3}, {2, 2}}, {true, true, true, false, true}},
      {{{1, 1, 2}, {1, 2, 1}, {2, 2, 2}}, {true, true, false}},
  };
  for (const auto& c : cases) EXPECT_EQ(non_dominated(c.points), c.front);
}

TEST(Front, IsWhatNoOtherPointBeats) {
  std::mt19937 random(1);
  for (int round = 0; round < 50; ++round) {
    std::vector<std::vector<double>> points(60, std::vector<double>(2 + round % 2));
    for (auto& costs : points)
      std::generate(costs.begin(), costs.end(), [&] { return static_cast<double>(random() % 20); });
    const std::vector<bool> front = non_dominated(points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const bool beaten =
          std::any_of(points.begin(), points.end(), [&](const auto& other) { return dominates(other, points[i]); });
      EXPECT_EQ(front[i], !beaten) << ::testing::PrintToString(points[i]);
    }
  }
}

}  // namespace
}  // namespace grtx::explore
