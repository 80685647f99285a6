// SPDX-License-Identifier: Apache-2.0
// The 16-bit formats against their definitions, and the response in them against fp32.
#include "grtx/frontend/gaussian/response_precision.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace grtx::frontend {
namespace {

// The definition: the nearest multiple of the value's last place, ties to even.
float nearest(double x, int significand_bits, int least_exponent) {
  if (x == 0.0) return 0.0f;
  const int exponent = std::max(std::ilogb(x), least_exponent);
  const double step = std::ldexp(1.0, exponent - significand_bits);
  return static_cast<float>(std::nearbyint(x / step) * step);
}

TEST(ResponsePrecision, RoundsAsDefined) {
  std::uint32_t state = 1;
  for (int i = 0; i < 200000; ++i) {
    state = state * 1664525u + 1013904223u;
    const float x =
        std::ldexp(static_cast<float>(state >> 8) - 8388608.0f, static_cast<int>(state % 40u) - 47);  // 2^-47 to 2^15
    EXPECT_EQ(round_to_fp16(x), nearest(static_cast<double>(x), 10, -14)) << x;
    EXPECT_EQ(round_to_bf16(x), nearest(static_cast<double>(x), 7, -126)) << x;
  }
}

TEST(ResponsePrecision, KeepsSpecialValues) {
  const float infinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(round_to_fp16(65519.0f), 65504.0f);
  EXPECT_EQ(round_to_fp16(65520.0f), infinity);
  EXPECT_EQ(round_to_fp16(-infinity), -infinity);
  EXPECT_EQ(round_to_bf16(infinity), infinity);
  EXPECT_TRUE(std::isnan(round_to_fp16(std::nanf(""))));
  EXPECT_TRUE(std::isnan(round_to_bf16(std::nanf(""))));
  EXPECT_EQ(round_to_fp16(0.5f + 0.5f / 1024), 0.5f + 0.5f / 1024);
}

TEST(ResponsePrecision, AlphaStaysWithinTheFormatsError) {
  // Five roundings of at most half a last place; the exponent's error is multiplied by its size, at most 4.5.
  const double fp16 = std::ldexp(1.0, -11), bf16 = std::ldexp(1.0, -8);
  for (float opacity = 0.1f; opacity <= 1.0f; opacity += 0.07f) {
    const float kappa = static_cast<float>(kernel_radius(static_cast<double>(opacity), true));
    for (float d2 = 0.0f; d2 <= 1.0f; d2 += 0.013f) {
      const double exact = static_cast<double>(hit_alpha(opacity, kappa * kappa, d2));
      const auto bound = [exact](double unit) { return exact * unit * (4.0 + 4.0 * 4.5) * 1.1; };
      if (exact < 0.0045) continue;  // near the threshold a hit may vanish
      EXPECT_NEAR(static_cast<double>(hit_alpha_16(opacity, kappa * kappa, d2, ResponsePrecision::fp16)), exact,
                  bound(fp16));
      EXPECT_NEAR(static_cast<double>(hit_alpha_16(opacity, kappa * kappa, d2, ResponsePrecision::bf16)), exact,
                  bound(bf16));
    }
  }
}

TEST(ResponsePrecision, WhatDoesNotCountStaysOut) {
  for (const ResponsePrecision p : {ResponsePrecision::fp16, ResponsePrecision::bf16}) {
    EXPECT_EQ(hit_alpha_16(1.0f, 9.0f, 1.0000001f, p), 0.0f);
    EXPECT_EQ(hit_alpha_16(0.0035f, 0.06f, 0.0f, p), 0.0f);
    EXPECT_EQ(hit_alpha_16(0.5f, 9.0f, std::nanf(""), p), 0.0f);
  }
}

}  // namespace
}  // namespace grtx::frontend
