// SPDX-License-Identifier: Apache-2.0
// How opaque the hits are that a ray has found: as soon as they let less light through than the threshold of early
// termination, nothing behind the last of them is seen (Header::opacity_bound). Opacities are whole numbers, so the sum
// depends on no order, and an entry that leaves is subtracted exactly. docs/model/numerics.md, "Bound by opacity".
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "grtx/traces/modes.h"

namespace grtx::traces {

/// Steps of an opacity in a factor 2 of transmittance.
inline constexpr int kOpacitySteps = 1024;
/// Most entries of the k-buffer that one hit hides: Event::hidden() has a byte for them. Others wait for the next hit.
inline constexpr unsigned kMostHidden = 255;

namespace detail {
/// By the first eight bits of a mantissa: steps from 1 to the next mantissa of eight bits, rounded up.
constexpr std::array<std::uint16_t, 256> mantissa_steps() {
  std::array<std::uint16_t, 256> steps{};
  for (std::uint64_t i = 0; i < 256; ++i) {
    // A digit of the logarithm is whether the square reaches 2. Both squares are rounded up, and so is the last digit.
    std::uint64_t x = (257 + i) << 23, log = 0;  // 1 is 2^31
    for (int digit = 0; digit < 20; ++digit) {
      x = (x * x + ((std::uint64_t{1} << 31) - 1)) >> 31;
      log = 2 * log + (x >> 32);
      x = (x + (x >> 32)) >> (x >> 32);
    }
    steps[i] = static_cast<std::uint16_t>(i == 255 ? kOpacitySteps : (log >> 10) + 1);
  }
  return steps;
}
inline constexpr std::array<std::uint16_t, 256> kMantissaSteps = mantissa_steps();
}  // namespace detail

/// Steps that are more than log2(x), for a normal x > 0: those of the next number above x with eight bits of mantissa.
constexpr int steps_above(float x) {
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(x);
  const int exponent = static_cast<int>(bits >> 23) - 127;
  return kOpacitySteps * exponent + detail::kMantissaSteps[bits >> 15 & 255];
}

/// Steps by which a hit of this alpha, at most 0.99, darkens what is behind it, at least. 0 where it does not count.
constexpr std::uint32_t opacity_steps(float alpha) {
  const int steps = -steps_above(1.0f - alpha);
  return static_cast<std::uint32_t>(steps > 0 ? steps : 0);
}

class OpacitySum {
 public:
  /// ert: transmittance below which a ray ends; above 0.
  OpacitySum(OpacityBound bound, float ert) : on_(bound == OpacityBound::on), ert_(ert) {}

  bool on() const { return on_; }
  /// transmittance: what the hits blended so far leave.
  void begin_round(float transmittance) {
    sum_ = 0;
    to_end_ = on_ ? static_cast<std::uint32_t>(steps_above(transmittance / ert_)) : 0;
  }
  void add(std::uint32_t steps) { sum_ += steps; }
  void subtract(std::uint32_t steps) { sum_ -= steps; }
  /// Whether a ray ends at the hits that are in the sum, or before.
  bool ends() const { return on_ && sum_ >= to_end_; }
  bool ends_without(std::uint32_t steps) const { return on_ && sum_ >= to_end_ + steps; }

 private:
  bool on_;
  float ert_;
  std::uint32_t sum_ = 0;
  std::uint32_t to_end_ = 0;
};

}  // namespace grtx::traces
