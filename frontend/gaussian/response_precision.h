// SPDX-License-Identifier: Apache-2.0
// The response of a Gaussian in emulated 16-bit arithmetic, as a blending unit of half the width would compute it.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "grtx/frontend/gaussian/gaussian_math.h"
#include "grtx/frontend/gaussian/hit_options.h"

namespace grtx::frontend {

/// Nearest value with `kept` explicit significand bits (ties to even) of a normal fp32 number.
constexpr float round_significand(float x, unsigned kept) {
  const std::uint32_t dropped = 23 - kept;
  std::uint32_t bits = std::bit_cast<std::uint32_t>(x);
  const std::uint32_t half = (1u << (dropped - 1)) - 1u + ((bits >> dropped) & 1u);
  bits = (bits + half) & ~((1u << dropped) - 1u);
  return std::bit_cast<float>(bits);
}

/// IEEE 754 binary16: 10 significand bits, subnormal below 2^-14, infinity from 65520 on. NaN and infinities stay.
constexpr float round_to_fp16(float x) {
  if (!(x - x == 0.0f)) return x;
  const float magnitude = x < 0.0f ? -x : x;
  if (magnitude < 6.103515625e-05f) {
    // Adding and subtracting 1.5 * 2^(23 - 24) leaves multiples of 2^-24, the step of subnormals.
    constexpr float kAnchor = 0.75f;
    const float rounded = (magnitude + kAnchor) - kAnchor;
    return x < 0.0f ? -rounded : rounded;
  }
  if (magnitude >= 65520.0f) return x < 0.0f ? -INFINITY : INFINITY;
  return round_significand(x, 10);
}

/// bfloat16: the upper half of an fp32. NaN and infinities stay.
constexpr float round_to_bf16(float x) { return x - x == 0.0f ? round_significand(x, 7) : x; }

/// As hit_alpha(), with the inputs and every intermediate rounded to `precision`. Which hits count (d2 <= 1) stays
/// exact: the intersection unit decides it.
inline float hit_alpha_16(float opacity, float kappa2, float d2, ResponsePrecision precision, unsigned degree = 2) {
  if (!(d2 <= 1.0f)) return 0.0f;
  const auto round = [precision](float x) {
    return precision == ResponsePrecision::fp16 ? round_to_fp16(x) : round_to_bf16(x);
  };
  const float sigma2 = round(round(kappa2) * round(d2));
  const float exponent = degree == 4 ? round(round(sigma2 * sigma2) / -18.0f) : round(-0.5f * sigma2);
  const float alpha = round(std::min(kAlphaMax, round(round(opacity) * round(exp_negative(exponent)))));
  return alpha >= round(kAlphaMin) ? alpha : 0.0f;
}

}  // namespace grtx::frontend
