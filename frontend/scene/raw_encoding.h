// SPDX-License-Identifier: Apache-2.0
// How RawRows encodes colour, opacity and scale, for readers of formats that store them in another way.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string_view>

namespace grtx::frontend {

inline constexpr double kShC0 = 0.28209479177387814;  ///< value of the first spherical harmonic, 1 / (2 sqrt(pi))

/// Inverse of the sigmoid; -infinity at 0 and +infinity at 1.
inline float logit_of(double opacity) { return static_cast<float>(std::log(opacity) - std::log1p(-opacity)); }

/// Logarithm of a scale. Exactly 0 gives -100, which is clamped to the smallest scale like that of any tiny one.
inline float log_of_scale(double scale) { return scale == 0.0 ? -100.0f : static_cast<float>(std::log(scale)); }

/// The value of an IEEE 754 binary16.
inline double half_to_double(std::uint16_t bits) {
  const int exponent = (bits >> 10) & 31;
  const double fraction = bits & 1023;
  double value = 0.0;
  if (exponent == 31) {
    value = fraction == 0.0 ? std::numeric_limits<double>::infinity() : std::numeric_limits<double>::quiet_NaN();
  } else {
    value = exponent == 0 ? std::ldexp(fraction, -24) : std::ldexp(fraction + 1024.0, exponent - 25);
  }
  return (bits & 0x8000) != 0 ? -value : value;
}

/// The little-endian value at offset `at`, which must lie inside.
template <typename T>
T load(std::string_view bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

}  // namespace grtx::frontend
