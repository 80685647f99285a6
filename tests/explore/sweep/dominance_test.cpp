// Which designs no other beats, in any number of costs.
#include "grtx/explore/sweep/dominance.h"

#include <gtest/gtest.h>

namespace grtx::sim {
namespace {

TEST(Dominance, IsNoWorseInAllAndBetterInOne) {
  EXPECT_TRUE(dominates({1, 2, 3}, {1, 2, 4}));
  EXPECT_FALSE(dominates({1, 2, 3}, {1, 2, 3}));
  EXPECT_FALSE(dominates({1, 2, 5}, {1, 3, 4}));
}

TEST(Dominance, AFrontHasEqualsAndLeavesOutWhatTakesNoPart) {
  EXPECT_EQ(non_dominated({{1, 3}, {2, 2}, {3, 1}, {3, 3}, {2, 2}, {}}),
            (std::vector<bool>{true, true, true, false, true, false}));
  EXPECT_EQ(non_dominated({{1, 1, 2}, {1, 2, 1}, {2, 2, 2}}), (std::vector<bool>{true, true, false}));
}

}  // namespace
}  // namespace grtx::sim
