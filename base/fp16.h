// SPDX-License-Identifier: Apache-2.0
// IEEE 754 binary16: rounding to it, and its bits.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace grtx {

/// Nearest value with `kept` explicit significand bits (ties to even) of a normal fp32 number.
constexpr float round_significand(float x, unsigned kept) {
  const std::uint32_t dropped = 23 - kept;
  std::uint32_t bits = std::bit_cast<std::uint32_t>(x);
  const std::uint32_t half = (1u << (dropped - 1)) - 1u + ((bits >> dropped) & 1u);
  bits = (bits + half) & ~((1u << dropped) - 1u);
  return std::bit_cast<float>(bits);
}

/// 10 significand bits, subnormal below 2^-14, infinity from 65520 on. NaN and infinities stay.
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

/// The 16 bits of round_to_fp16(x); each NaN is the quiet one of its sign, and -0 becomes 0.
constexpr std::uint16_t fp16_bits(float x) {
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(round_to_fp16(x));
  const std::uint32_t sign = bits >> 16 & 0x8000u, magnitude = bits & 0x7FFFFFFFu;
  constexpr std::uint32_t kInfinity = 0x7F800000u, kLeastNormal = 0x38800000u;  // of fp32, and 2^-14
  if (magnitude >= kInfinity) return static_cast<std::uint16_t>(sign | (magnitude > kInfinity ? 0x7E00u : 0x7C00u));
  if (magnitude >= kLeastNormal) return static_cast<std::uint16_t>(sign | (magnitude - (112u << 23)) >> 13);
  return static_cast<std::uint16_t>(sign | static_cast<std::uint32_t>(std::bit_cast<float>(magnitude) * 0x1p24f));
}

}  // namespace grtx
