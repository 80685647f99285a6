// SPDX-License-Identifier: Apache-2.0
// NSGA-II over choices: it finds a front that is known, and the same one for the same seed.
#include "grtx/explore/search/nsga2.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "grtx/explore/sweep/dominance.h"

namespace grtx::explore {
namespace {

using Costs = std::vector<double>;

/// Distances from two corners in the first two dimensions, and everywhere the third is only a loss: the front is where
/// it is 0 and the others are equal.
Costs two_corners(const Choices& d) {
  const double x = static_cast<double>(d[0]), y = static_cast<double>(d[1]), loss = static_cast<double>(d[2]);
  const double off = std::fabs(x - y);
  return {1.0 + x + 2.0 * off + loss, 31.0 - x + 2.0 * off + loss};
}
const SearchSpace kThree = {{{30, true}, {30, true}, {9, false}}};  // 8,100 designs, 30 on the front

struct Trial {
  std::vector<Choices> asked;
  std::map<Choices, Costs> known;
  std::size_t evaluated_count = 0;

  Trial(const SearchSpace& space, unsigned seed, unsigned population, unsigned generations,
        const std::vector<Choices>& first, Costs (*cost)(const Choices&)) {
    Nsga2 nsga2(space, seed, population, cost(Choices(space.dimensions.size(), 0)).size(), first,
                [&](const std::vector<Choices>& designs) {
                  std::vector<Costs> costs;
                  for (const Choices& design : designs) {
                    asked.push_back(design);
                    costs.push_back(known[design] = cost(design));
                  }
                  return costs;
                });
    for (unsigned i = 0; i < generations; ++i) nsga2.step();
    evaluated_count = nsga2.evaluated_count();
  }
  std::set<Choices> front() const {
    std::vector<Costs> costs;
    for (const auto& [design, cost] : known) costs.push_back(cost);
    const std::vector<bool> on = non_dominated(costs);
    std::set<Choices> front;
    std::size_t i = 0;
    for (const auto& [design, cost] : known) {
      if (on[i++]) front.insert(design);
    }
    return front;
  }
};

TEST(Nsga2, FindsAFrontInAFractionOfTheSpace) {
  const Trial run(kThree, 1, 40, 25, {}, two_corners);
  std::size_t found = 0;
  for (std::size_t i = 0; i < 30; ++i) found += run.front().contains({i, i, 0}) ? 1 : 0;
  EXPECT_EQ(run.evaluated_count, run.known.size());
  EXPECT_LE(run.evaluated_count, 1040U);  // an eighth of the space
  // As many looks at random would find 30 / 8 of them. Two dimensions must agree: a hard front for crossover.
  EXPECT_GE(found, 10U);
}

TEST(Nsga2, TheSeedDecidesEverything) {
  const Trial a(kThree, 7, 16, 6, {}, two_corners), b(kThree, 7, 16, 6, {}, two_corners),
      other(kThree, 8, 16, 6, {}, two_corners);
  EXPECT_EQ(a.asked, b.asked);
  EXPECT_NE(a.asked, other.asked);
}

TEST(Nsga2, BeginsWithWhatIsGiven) {
  const Trial run(kThree, 1, 8, 0, {{3, 4, 5}, {3, 4, 5}, {1, 2, 3}}, two_corners);
  EXPECT_EQ(run.asked.size(), 8U);
  EXPECT_EQ(run.asked[0], (Choices{3, 4, 5}));
  EXPECT_EQ(run.asked[1], (Choices{1, 2, 3}));
}

TEST(Nsga2, ASmallSpaceIsSeenWhole) {
  const SearchSpace space = {{{3, true}, {2, false}, {4, true}}};
  const Trial run(space, 1, 8, 20, {}, [](const Choices& d) -> Costs {
    return {static_cast<double>(d[0]), static_cast<double>(d[1] + d[2])};  // one design beats all: copies abound
  });
  EXPECT_EQ(run.evaluated_count, 24U);
  EXPECT_EQ(run.front(), (std::set<Choices>{{0, 0, 0}}));
}

TEST(Nsga2, OneCostIsEnough) {
  const Trial run(kThree, 1, 16, 25, {}, [](const Choices& d) -> Costs { return {two_corners(d)[0]}; });
  EXPECT_EQ(run.front(), (std::set<Choices>{{0, 0, 0}}));
}

TEST(Nsga2, EveryChoiceIsWithinItsDimension) {
  const SearchSpace space = {{{2, false}, {5, true}, {3, false}, {2, true}}};
  EXPECT_EQ(space.size(), 60.0);
  std::vector<std::set<std::size_t>> seen(4);
  for (const Choices& design : Trial(space, 3, 8, 30, {}, two_corners).asked) {
    ASSERT_EQ(design.size(), 4U);
    for (std::size_t i = 0; i < 4; ++i) seen[i].insert(design[i]);
  }
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(seen[i].size(), space.dimensions[i].choices);
    EXPECT_EQ(*seen[i].rbegin(), space.dimensions[i].choices - 1);
  }
}

}  // namespace
}  // namespace grtx::explore
