// SPDX-License-Identifier: Apache-2.0
#include "grtx/base/geometric_mean.h"

#include <gtest/gtest.h>

#include <cmath>

namespace grtx {
namespace {

TEST(GeometricMean, OfRatiosAndTheirReciprocalsIsOne) {
  EXPECT_DOUBLE_EQ(geometric_mean({1.0, 4.0}), 2.0);
  EXPECT_DOUBLE_EQ(geometric_mean({0.25, 4.0, 1.0}), 1.0);
}

TEST(GeometricMean, OneValueKeepsItsLastBit) {  // exp(log(x)) rounds twice
  for (const double value : {1074.0, 0.1, 3.7}) EXPECT_EQ(geometric_mean({value}), value);
}

TEST(GeometricMean, OfNoneIsNoNumber) { EXPECT_TRUE(std::isnan(geometric_mean({}))); }

}  // namespace
}  // namespace grtx
