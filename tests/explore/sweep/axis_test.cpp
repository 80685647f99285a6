// SPDX-License-Identifier: Apache-2.0
// How a plan's axes become points: every combination, seeded draws, Latin hypercubes.
#include "grtx/explore/sweep/axis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace grtx::explore {
namespace {

Axis choices(const std::string& name, std::vector<SweepValue> values) {
  Axis axis;
  axis.name = name;
  axis.values = std::move(values);
  return axis;
}

Axis range(double from, double to, bool logarithmic, bool integer, unsigned steps = 0) {
  Axis axis;
  axis.name = "x";
  axis.from = from;
  axis.to = to;
  axis.logarithmic = logarithmic;
  axis.integer = integer;
  axis.steps = steps;
  return axis;
}

std::vector<std::string> texts(const std::vector<Coordinates>& points, const std::string& name) {
  std::vector<std::string> list;
  for (const Coordinates& point : points) {
    for (const auto& [axis, value] : point) {
      if (axis == name) list.push_back(text_of(value));
    }
  }
  return list;
}

TEST(SweepAxis, AGridHasEveryCombinationAndItsLastAxisVariesFastest) {
  const auto points = grid_points({choices("a", {1, 2}), choices("b", {"x", "y", "z"})});
  EXPECT_EQ(texts(points, "a"), (std::vector<std::string>{"1", "1", "1", "2", "2", "2"}));
  EXPECT_EQ(texts(points, "b"), (std::vector<std::string>{"x", "y", "z", "x", "y", "z"}));
}

TEST(SweepAxis, ARangeOfAGridGoesFromEndToEnd) {
  const struct {
    Axis axis;
    std::vector<std::string> values;
  } cases[] = {{range(0, 1, false, false, 5), {"0.0", "0.25", "0.5", "0.75", "1.0"}},
               {range(1, 100, true, false, 3), {"1.0", "10.0", "100.0"}},
               {range(1, 64, true, true, 7), {"1", "2", "4", "8", "16", "32", "64"}},
               {range(1, 3, false, true, 5), {"1", "2", "3"}},  // what rounds to the same is one
               {range(7, 9, false, true, 1), {"7"}}};
  for (const auto& c : cases) EXPECT_EQ(texts(grid_points({c.axis}), "x"), c.values);
}

TEST(SweepAxis, TheSameSeedDrawsTheSamePoints) {
  const std::vector<Axis> axes = {range(0, 1, false, false)};
  EXPECT_EQ(texts(random_points(axes, 3, 1), "x"),
            (std::vector<std::string>{"0.566561575", "0.745781757", "0.971002754"}));
  EXPECT_NE(texts(random_points(axes, 3, 1), "x"), texts(random_points(axes, 3, 2), "x"));
}

TEST(SweepAxis, EveryValueOfAnIntegerRangeIsDrawn) {
  for (const bool logarithmic : {false, true}) {
    std::set<std::string> drawn;
    for (const std::string& value : texts(random_points({range(1, 8, logarithmic, true)}, 500, 3), "x")) {
      drawn.insert(value);
    }
    EXPECT_EQ(drawn, (std::set<std::string>{"1", "2", "3", "4", "5", "6", "7", "8"}));
  }
}

TEST(SweepAxis, ALatinHypercubeUsesEachStratumOnce) {
  const auto points = latin_points({range(0, 16, false, false), choices("b", {1, 2, 3, 4})}, 16, 5);
  std::multiset<int> strata;
  for (const std::string& value : texts(points, "x")) strata.insert(static_cast<int>(std::stod(value)));
  for (int i = 0; i < 16; ++i) EXPECT_EQ(strata.count(i), 1U) << i;
  std::multiset<std::string> choice;
  for (const std::string& value : texts(points, "b")) choice.insert(value);
  for (const char* value : {"1", "2", "3", "4"}) EXPECT_EQ(choice.count(value), 4U);
}

}  // namespace
}  // namespace grtx::explore
