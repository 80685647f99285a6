// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/scene/readers.h"

#include <cmath>
#include <cstdint>

#include "grtx/frontend/scene/raw_encoding.h"

namespace grtx::frontend {
namespace {

constexpr std::size_t kRowBytes = 32;  // 3 f32 position, 3 f32 linear scale, 4 u8 r g b a, 4 u8 rotation w x y z
constexpr std::size_t kScaleAt = 12;
constexpr std::size_t kColourAt = 24;
constexpr std::size_t kRotationAt = 28;

// Text read as floats has magnitudes of 1e-19 or 1e12 and more; random bits are plausible in one row of eight or fewer.
// A row of zeros is padding of something else.
bool is_plausible_row(std::string_view row) {
  if (row.substr(0, kRowBytes).find_first_not_of('\0') == std::string_view::npos) return false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float position = load<float>(row, axis * 4);
    const float scale = load<float>(row, kScaleAt + axis * 4);
    if (!(std::abs(position) < 1e9f) || !(scale >= 0.0f && scale < 1e6f)) return false;
  }
  return true;
}

}  // namespace

bool is_splat(std::string_view bytes) {
  if (bytes.empty() || bytes.size() % kRowBytes != 0) return false;
  const std::size_t rows = bytes.size() / kRowBytes;
  std::size_t plausible = 0;
  for (std::size_t row = 0; row < rows; ++row) plausible += is_plausible_row(bytes.substr(row * kRowBytes));
  return plausible * 2 > rows;
}

RawRows read_splat(std::string_view bytes) {
  const std::size_t n = bytes.size() / kRowBytes;
  RawRows rows;
  rows.x.reserve(n);
  rows.y.reserve(n);
  rows.z.reserve(n);
  rows.opacity_logit.reserve(n);
  rows.log_scale.reserve(n * 3);
  rows.rotation.reserve(n * 4);
  rows.sh.reserve(n * 3);
  for (std::size_t i = 0; i < n; ++i) {
    const std::string_view row = bytes.substr(i * kRowBytes);
    rows.x.push_back(static_cast<double>(load<float>(row, 0)));
    rows.y.push_back(static_cast<double>(load<float>(row, 4)));
    rows.z.push_back(static_cast<double>(load<float>(row, 8)));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      rows.log_scale.push_back(log_of_scale(static_cast<double>(load<float>(row, kScaleAt + axis * 4))));
    }
    for (std::size_t c = 0; c < 3; ++c) {
      rows.sh.push_back(static_cast<float>((load<std::uint8_t>(row, kColourAt + c) / 255.0 - 0.5) / kShC0));
    }
    rows.opacity_logit.push_back(logit_of(load<std::uint8_t>(row, kColourAt + 3) / 255.0));
    for (std::size_t c = 0; c < 4; ++c) {  // the original writer's code: 128 is 0
      rows.rotation.push_back((static_cast<float>(load<std::uint8_t>(row, kRotationAt + c)) - 128.0f) / 128.0f);
    }
  }
  return rows;
}

}  // namespace grtx::frontend
