// SPDX-License-Identifier: Apache-2.0
// The response of a Gaussian in emulated 16-bit arithmetic, as a blending unit of half the width would compute it.
#pragma once

#include "grtx/base/fp16.h"
#include "grtx/frontend/gaussian/gaussian_math.h"
#include "grtx/frontend/gaussian/hit_options.h"

namespace grtx::frontend {

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
