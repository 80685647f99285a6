// Fast mode's correction, against sums by hand.
#include "grtx/rtl_tlm/estimate/sampled/fast_correction.h"

#include <gtest/gtest.h>

#include <cmath>

namespace grtx::sim {
namespace {

TEST(FastCorrection, IsTheRatioOfWeightedEnds) {
  const FastSample sample{{4, 9}, {3.0, 1.0}, {1100.0, 2000.0}, {1000.0, 2000.0}};
  const FastCorrection c = correct_fast({sample});
  const double factor = 5300.0 / 5000.0, mean = 5300.0 / 4.0;
  // Two influences of 3 x 40 / 5300, one group too few: shrunk against the model's own spread.
  const double variance = 2.0 * std::pow(120.0 / 5300.0, 2) * 3.0 / 2.0;
  const double trust = kFastSpread * kFastSpread / (kFastSpread * kFastSpread + variance);
  EXPECT_NEAR(c.log_factor, trust * std::log(factor), 1e-12);
  EXPECT_NEAR(c.prior_variance, std::pow((1.0 - trust) * kFastSpread, 2), 1e-12);
  ASSERT_EQ(c.evidence.size(), 2U);
  EXPECT_EQ(c.evidence[0].group, 4U);
  EXPECT_NEAR(c.evidence[0].residual, (1060.0 - 1100.0) / mean, 1e-12);
  EXPECT_NEAR(c.evidence[1].residual, (2120.0 - 2000.0) / mean, 1e-12);
  // Influences add up to nothing, and are what a small change of an end does.
  EXPECT_NEAR(c.evidence[0].influence + c.evidence[1].influence, 0.0, 1e-12);
  EXPECT_NEAR(c.evidence[0].influence, trust * 3.0 * 40.0 / 5300.0, 1e-12);
}

TEST(FastCorrection, IsOneWhereTheModelIsRight) {
  const FastSample sample{{1, 2, 3}, {5.0, 5.0, 5.0}, {10.0, 20.0, 30.0}, {10.0, 20.0, 30.0}};
  const FastCorrection c = correct_fast({sample, sample});
  EXPECT_EQ(c.log_factor, 0.0);
  EXPECT_EQ(c.residual, 0.0);
  EXPECT_NEAR(c.degrees_of_freedom, 5.0, 1e-12);
}

TEST(FastCorrection, LeavesOutGroupsWithoutWork) {
  const FastSample sample{{1, 2}, {1.0, 0.0}, {20.0, 7.0}, {10.0, 500.0}};
  EXPECT_NEAR(correct_fast({sample}).log_factor, std::log(2.0), 1e-12);
  EXPECT_EQ(correct_fast({FastSample{}}).log_factor, 0.0);
}

}  // namespace
}  // namespace grtx::sim
