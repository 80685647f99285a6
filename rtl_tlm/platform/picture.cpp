// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/platform/picture.h"

#include <cstddef>

#include "grtx/base/colour_byte.h"
#include "grtx/base/fp16.h"

namespace grtx::sim {
namespace {

constexpr std::size_t kChannels = 4;

}  // namespace

unsigned pixel_bytes(PictureFormat format) {
  switch (format) {
    case PictureFormat::rgba8:
      return 4;
    case PictureFormat::rgba16f:
      return 8;
    case PictureFormat::none:
      break;
  }
  return 0;
}

std::vector<std::uint8_t> picture_row(PictureFormat format, std::span<const float> pixels) {
  std::vector<std::uint8_t> row;
  row.reserve(pixels.size() / kChannels * pixel_bytes(format));
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const float channel = i % kChannels == kChannels - 1 ? 1.0f : pixels[i];
    if (format == PictureFormat::rgba8) {
      row.push_back(colour_byte(channel));
    } else {
      const std::uint16_t bits = fp16_bits(channel);
      row.push_back(static_cast<std::uint8_t>(bits & 0xFF));
      row.push_back(static_cast<std::uint8_t>(bits >> 8));
    }
  }
  return row;
}

}  // namespace grtx::sim
