// SPDX-License-Identifier: Apache-2.0
// Opacities as whole numbers: what docs/model/numerics.md, "Bound by opacity", proves.
#include "grtx/traces/rules/opacity_sum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace grtx::traces {
namespace {

TEST(OpacitySum, TheTableIsTheLogarithmOfTheNextMantissaRoundedUp) {
  for (unsigned i = 0; i < 256; ++i) {
    const double steps = 1024.0 * std::log2(1.0 + (i + 1) / 256.0);
    const int expected = i == 255 ? 1024 : static_cast<int>(std::floor(steps)) + 1;
    EXPECT_EQ(detail::kMantissaSteps[i], expected) << i;
  }
}

TEST(OpacitySum, StepsLieAboveTheLogarithmByLessThanOneInAHundredOfAFactorOfTwo) {
  std::mt19937 random(1);
  for (int i = 0; i < 100000; ++i) {
    const float x =
        std::ldexp(1.0f + static_cast<float>(random() >> 9) * 0x1p-23f, static_cast<int>(random() % 60) - 30);
    const double rounded_up = std::log2(static_cast<double>(x) * (1.0 + 0x1p-24));
    EXPECT_GT(steps_above(x) / 1024.0, rounded_up);
    EXPECT_LT(steps_above(x) / 1024.0, rounded_up + 0.008);
  }
  EXPECT_EQ(steps_above(1.0f), 6);
  EXPECT_EQ(opacity_steps(0.0f), 0u);
  EXPECT_EQ(opacity_steps(0.001f), 0u);
  EXPECT_EQ(opacity_steps(0.5f), 1018u);
  EXPECT_EQ(opacity_steps(0.99f), 6801u);
}

/// Transmittance behind hits of these alphas, in the arithmetic that blends.
float blended(float transmittance, const std::vector<float>& alphas) {
  for (const float alpha : alphas) transmittance *= 1.0f - alpha;
  return transmittance;
}

// A ray whose hits reach the sum ends among them in any order, whatever enters between them.
TEST(OpacitySum, ARayThatItEndsEndsByBlending) {
  std::mt19937 random(2);
  const auto uniform = [&](float low, float high) {
    return low + (high - low) * static_cast<float>(random() >> 8) * 0x1p-24f;
  };
  double largest = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const float ert = std::pow(10.0f, uniform(-4.0f, -0.01f));
    const float before = std::max(ert, uniform(0.0f, 1.0f));
    const float most = i % 3 == 0 ? 0.02f : 0.99f;
    OpacitySum sum(OpacityBound::on, ert);
    sum.begin_round(before);
    std::vector<float> alphas;
    while (!sum.ends()) {
      alphas.push_back(uniform(1.0f / 255.0f, most));
      sum.add(opacity_steps(alphas.back()));
    }
    const float ends = blended(before, alphas);
    ASSERT_LT(ends, ert);
    alphas.pop_back();
    if (most > 0.9f)
      largest = std::max(largest, static_cast<double>(ert) / static_cast<double>(blended(before, alphas)));
    std::shuffle(alphas.begin(), alphas.end(), random);
    OpacitySum other(OpacityBound::on, ert);
    other.begin_round(before);
    for (const float alpha : alphas) other.add(opacity_steps(alpha));
    ASSERT_FALSE(other.ends()) << "the sum depends on no order";
  }
  EXPECT_LT(largest, 1.25) << "it fires late by less than that, one hit before";
}

TEST(OpacitySum, AHitThatEntersOnlyDarkens) {
  std::mt19937 random(3);
  for (int i = 0; i < 5000; ++i) {
    std::vector<float> alphas(1 + random() % 40);
    for (float& alpha : alphas) alpha = static_cast<float>(random() % 252 + 1) / 255.0f;
    const float before = blended(1.0f, alphas);
    alphas.insert(alphas.begin() + static_cast<std::ptrdiff_t>(random() % (alphas.size() + 1)), 1.0f / 255.0f);
    ASSERT_LE(blended(1.0f, alphas), before);
  }
}

TEST(OpacitySum, OffEndsNothing) {
  OpacitySum sum(OpacityBound::off, 0.0f);
  sum.begin_round(1.0f);
  sum.add(1000000);
  EXPECT_FALSE(sum.ends());
  EXPECT_FALSE(sum.ends_without(0));
}

}  // namespace
}  // namespace grtx::traces
