// SPDX-License-Identifier: Apache-2.0
// A channel of a picture in eight bits, in files and in a platform's memory alike.
#pragma once

#include <cmath>
#include <cstdint>

namespace grtx {

/// floor(255 c + 0.5) of the value c clamped to [0, 1]; NaN is 0.
inline std::uint8_t colour_byte(float value) {
  if (!(value > 0.0f)) return 0;
  if (value >= 1.0f) return 255;
  return static_cast<std::uint8_t>(std::floor(255.0 * static_cast<double>(value) + 0.5));
}

}  // namespace grtx
