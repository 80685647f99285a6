// The front of two costs: by hand, and against the definition on random points.
#include "grtx/explore/report/pareto.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace grtx::sim {
namespace {

TEST(ParetoFront, ByHand) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const struct {
    std::vector<Costs> points;
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
      {{{1, nan}, {2, 2}, {nan, 1}}, {false, true, false}},  // what was not measured is on no front
  };
  for (const auto& c : cases) EXPECT_EQ(pareto_front(c.points), c.front);
}

TEST(ParetoFront, IsWhatNoOtherPointBeats) {
  std::mt19937 random(1);
  for (int round = 0; round < 50; ++round) {
    std::vector<Costs> points(60);
    for (Costs& p : points) p = {static_cast<double>(random() % 20), static_cast<double>(random() % 20)};
    const std::vector<bool> front = pareto_front(points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      bool beaten = false;
      for (const Costs& o : points) {
        beaten = beaten || (o.first <= points[i].first && o.second <= points[i].second &&
                            (o.first < points[i].first || o.second < points[i].second));
      }
      EXPECT_EQ(front[i], !beaten) << points[i].first << " " << points[i].second;
    }
  }
}

}  // namespace
}  // namespace grtx::sim
