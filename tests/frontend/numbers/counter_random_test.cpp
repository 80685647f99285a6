// SPDX-License-Identifier: Apache-2.0
// Elementary functions and random numbers that are the same on every host.
#include "grtx/frontend/numbers/counter_random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "grtx/frontend/numbers/portable_math.h"

namespace grtx::frontend {
namespace {

TEST(PortableMath, AgreesWithTheLibraryToFifteenDigits) {
  for (int i = 0; i < 4000; ++i) {
    const double x = -30.0 + 0.015001 * i;
    EXPECT_NEAR(portable_exp(x) / std::exp(x), 1.0, 5e-15) << x;
    EXPECT_NEAR(portable_log(std::exp(x)), std::log(std::exp(x)), 1e-14 + 1e-15 * std::abs(x)) << x;
    const double u = 0.001237 * i - 2.5;
    EXPECT_NEAR(portable_turn(u).sine, std::sin(2.0 * 3.14159265358979323846 * u), 4e-15) << u;
    EXPECT_NEAR(portable_turn(u).cosine, std::cos(2.0 * 3.14159265358979323846 * u), 4e-15) << u;
  }
  EXPECT_EQ(portable_exp(0.0), 1.0);
  EXPECT_EQ(portable_log(1.0), 0.0);
  EXPECT_EQ(portable_turn(0.25).sine, 1.0);
}

TEST(CounterRandom, FirstNumbersAreFixed) {
  CounterRandom random(1, 2, 3);
  EXPECT_EQ(random.bits(), 3106261847631260135u);
  CounterRandom again(1, 2, 3);
  CounterRandom other(1, 3, 2);
  const std::uint64_t first = again.bits();
  EXPECT_NE(first, other.bits());
}

TEST(CounterRandom, DistributionsHaveTheirMoments) {
  CounterRandom random(5, 0, 0);
  constexpr int kCount = 40000;
  struct Case {
    double shape, scale;
  };
  for (const Case& c : {Case{2.2, 0.4}, Case{0.85, 5.5}, Case{1.0, 1.0}}) {
    double sum = 0.0;
    double square = 0.0;
    for (int i = 0; i < kCount; ++i) {
      const double x = random.gamma(c.shape, c.scale);
      ASSERT_GE(x, 0.0);
      sum += x;
      square += x * x;
    }
    const double average = sum / kCount;
    EXPECT_NEAR(average, c.shape * c.scale, 0.03 * c.shape * c.scale);
    EXPECT_NEAR(square / kCount - average * average, c.shape * c.scale * c.scale, 0.08 * c.shape * c.scale * c.scale);
  }
  double sum = 0.0;
  double square = 0.0;
  glm::dvec3 direction(0.0);
  for (int i = 0; i < kCount; ++i) {
    const double x = random.normal();
    sum += x;
    square += x * x;
    const glm::dvec3 d = random.direction();
    ASSERT_NEAR(glm::length(d), 1.0, 1e-12);
    direction += d;
  }
  EXPECT_NEAR(sum / kCount, 0.0, 0.02);
  EXPECT_NEAR(square / kCount, 1.0, 0.03);
  EXPECT_LT(glm::length(direction) / kCount, 0.02);
}

TEST(CounterRandom, NoiseIsSmoothAndBounded) {
  double largest = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const glm::dvec3 at(0.01 * i, -0.37 * i, 5.1);
    const double here = value_noise(3, at);
    largest = std::max(largest, std::abs(here));
    EXPECT_NEAR(value_noise(3, at + glm::dvec3(1e-6)), here, 2e-5);
  }
  EXPECT_LE(largest, 1.0);
  EXPECT_GT(largest, 0.3);
}

TEST(CounterPermutation, VisitsEveryIndexOnce) {
  for (const std::uint64_t count : {1u, 2u, 3u, 4u, 5u, 1000u, 65536u, 65537u}) {
    const CounterPermutation order(9, count);
    std::vector<bool> seen(count, false);
    std::uint64_t fixed = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::uint64_t to = order(i);
      ASSERT_LT(to, count);
      ASSERT_FALSE(seen[to]);
      seen[to] = true;
      fixed += to == i ? 1 : 0;
    }
    if (count >= 1000) {
      EXPECT_LT(fixed, 20u) << count;
    }
  }
}

}  // namespace
}  // namespace grtx::frontend
