// SPDX-License-Identifier: Apache-2.0
// Kernel radius against published values, the exponential against libm, SH against a plain table.
#include "grtx/frontend/gaussian/gaussian_math.h"

#include <gtest/gtest.h>

namespace grtx::frontend {
namespace {

TEST(GaussianMath, KernelRadius) {
  EXPECT_NEAR(kernel_radius(1.0, true), 2.9943, 5e-5);
  EXPECT_NEAR(kernel_radius(0.5, true), 2.7531, 5e-5);
  EXPECT_NEAR(kernel_radius(0.1, true), 2.0882, 5e-5);
  EXPECT_NEAR(kernel_radius(0.005, true), 0.2468, 5e-5);
  EXPECT_NEAR(kernel_radius(0.0, true), 0.2468, 5e-5);
  EXPECT_EQ(kernel_radius(0.3, false), 3.0);
  // 3DGRT's table for degree 4.
  for (const auto& [opacity, radius] :
       {std::pair(1.0, 2.9972), {0.5, 2.8739}, {0.1, 2.5029}, {0.02, 1.7905}, {0.005, 0.8605}}) {
    EXPECT_NEAR(kernel_radius(opacity, {true, 4}), radius, 5e-5) << opacity;
  }
}

TEST(GaussianMath, ExponentialIsWithinOneUlp) {
  for (int i = 0; i <= 100000; ++i) {
    const float x = -4.7f * static_cast<float>(i) / 100000.0f;
    const float exact = static_cast<float>(std::exp(static_cast<double>(x)));
    ASSERT_NEAR(exp_negative(x), exact, exact * 1.2e-7f) << x;
  }
  EXPECT_EQ(exp_negative(0.0f), 1.0f);
}

TEST(GaussianMath, AlphaRules) {
  EXPECT_EQ(hit_alpha(1.0f, 9.0f, 0.0f), 0.99f);      // clamped
  for (const double d : {0.0, 0.5, 1.0, 2.0, 2.9}) {  // standard deviations, of a radius of 3
    EXPECT_NEAR(hit_alpha(0.5f, 9.0f, static_cast<float>(d * d / 9.0), 4), 0.5 * std::exp(-std::pow(d, 4.0) / 18.0),
                1e-7)
        << d;
  }
  EXPECT_EQ(hit_alpha(1.0f, 9.0f, 1.0000001f), 0.0f);  // outside the kernel radius
  EXPECT_EQ(hit_alpha(0.0039f, 0.06f, 0.0f), 0.0f);    // below 1/255
  EXPECT_EQ(hit_alpha(0.5f, 9.0f, std::nanf("")), 0.0f);
}

TEST(GaussianMath, ShBasisIsOrthonormal) {
  // Integrates products of basis functions over a fine spherical grid.
  double gram[25][25] = {};
  const int rows = 200, columns = 400;
  for (int i = 0; i < rows; ++i) {
    const double z = -1.0 + (2.0 * i + 1.0) / rows;
    for (int j = 0; j < columns; ++j) {
      const double phi = 2.0 * 3.141592653589793 * (j + 0.5) / columns, s = std::sqrt(1.0 - z * z);
      const auto b = sh_basis(
          {static_cast<float>(s * std::cos(phi)), static_cast<float>(s * std::sin(phi)), static_cast<float>(z)}, 4);
      for (int p = 0; p < 25; ++p) {
        for (int q = 0; q < 25; ++q)
          gram[p][q] +=
              static_cast<double>(b[static_cast<std::size_t>(p)]) * static_cast<double>(b[static_cast<std::size_t>(q)]);
      }
    }
  }
  for (int p = 0; p < 25; ++p) {
    for (int q = 0; q < 25; ++q) {
      EXPECT_NEAR(gram[p][q] * 4.0 * 3.141592653589793 / (rows * columns), p == q ? 1.0 : 0.0, 1e-3);
    }
  }
}

TEST(GaussianMath, UnitVectorsOfAnyLength) {
  for (const float length : {1e-38f, 1e-30f, 1e-19f, 1.0f, 7.5f, 1e19f, 3e20f, 1e37f}) {
    const glm::vec3 v = unit_vector({2.0f * length, -length, 2.0f * length});
    EXPECT_NEAR(v.x, 2.0 / 3.0, 1e-6) << length;
    EXPECT_NEAR(v.y, -1.0 / 3.0, 1e-6) << length;
    EXPECT_NEAR(v.z, 2.0 / 3.0, 1e-6) << length;
  }
}

}  // namespace
}  // namespace grtx::frontend
