// SPDX-License-Identifier: Apache-2.0
// What each parameter contributes: recovered from samples that mix the parameters up.
#include "grtx/explore/search/main_effects.h"

#include <gtest/gtest.h>

#include <cmath>

namespace grtx::explore {
namespace {

const SearchSpace kSpace = {{{2, true}, {3, true}}};

TEST(MainEffects, AreFactorsThatUnevenSamplesDoNotMix) {
  // Cost: 1 or 2 by the first, 1, 4 or 16 by the second. The first's 1 is mostly seen with the second's 0.
  std::vector<Choices> designs = {{0, 0}, {1, 1}, {1, 2}, {1, 0}, {0, 1}, {1, 2}, {1, 1}};
  std::vector<double> costs;
  for (const Choices& d : designs) costs.push_back((d[0] == 1 ? 2.0 : 1.0) * std::pow(4.0, static_cast<double>(d[1])));
  const MainEffects effects = main_effects(kSpace, designs, costs);
  EXPECT_NEAR(effects.factors[0][1] / effects.factors[0][0], 2.0, 1e-6);
  EXPECT_NEAR(effects.factors[1][1] / effects.factors[1][0], 4.0, 1e-6);
  EXPECT_NEAR(effects.factors[1][2] / effects.factors[1][0], 16.0, 1e-6);
  EXPECT_NEAR(effects.explained, 1.0, 1e-9);
  EXPECT_EQ(effects.designs, (std::vector<std::vector<std::size_t>>{{2, 5}, {2, 3, 2}}));
}

TEST(MainEffects, WhatWasNotSeenHasNone) {
  const MainEffects effects = main_effects(kSpace, {{0, 0}, {1, 0}}, {3.0, 12.0});
  EXPECT_NEAR(effects.factors[0][0], 0.5, 1e-9);  // of the geometric mean, 6
  EXPECT_NEAR(effects.factors[0][1], 2.0, 1e-9);
  EXPECT_EQ(effects.factors[1], (std::vector<double>{1.0, 1.0, 1.0}));
  EXPECT_EQ(effects.designs[1], (std::vector<std::size_t>{2, 0, 0}));
}

TEST(MainEffects, AnInteractionIsNotExplained) {
  const MainEffects effects = main_effects(kSpace, {{0, 0}, {0, 1}, {1, 0}, {1, 1}}, {1.0, 2.0, 2.0, 1.0});
  EXPECT_NEAR(effects.explained, 0.0, 1e-9);
  EXPECT_EQ(main_effects(kSpace, {}, {}).explained, 0.0);
}

}  // namespace
}  // namespace grtx::explore
