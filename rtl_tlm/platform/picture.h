// SPDX-License-Identifier: Apache-2.0
// The picture of a launch in a platform's memory: where, and in which format.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace grtx::sim {

/// How a picture lies in memory: rows from the top, pixels from the left, channels from red to alpha, which is 1.
enum class PictureFormat : std::uint32_t {
  none = 0,
  rgba8 = 1,    ///< 4 B a pixel, the values of `grtx trace --image x.png`
  rgba16f = 2,  ///< 8 B a pixel, IEEE 754 binary16, little-endian
};

/// Where a launch leaves its picture.
struct Picture {
  PictureFormat format = PictureFormat::none;
  std::uint64_t address = 0;  ///< on the bus
  std::uint32_t pitch = 0;    ///< bytes from row to row; 0: those of a row
};

/// Bytes of a pixel; 0 of `none` and of numbers that are no format.
unsigned pixel_bytes(PictureFormat format);
/// A row of the picture from pixels of four floats.
std::vector<std::uint8_t> picture_row(PictureFormat format, std::span<const float> pixels);

}  // namespace grtx::sim
