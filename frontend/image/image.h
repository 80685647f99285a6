// SPDX-License-Identifier: Apache-2.0
// Float RGB images and their files.
#pragma once

#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace grtx::frontend {

struct Image {
  unsigned width = 0, height = 0;
  std::vector<glm::vec3> pixels;  ///< row-major, top row first, linear, unclamped

  Image() = default;
  Image(unsigned w, unsigned h) : width(w), height(h), pixels(static_cast<std::size_t>(w) * h, glm::vec3(0.0f)) {}
  glm::vec3& at(unsigned x, unsigned y) { return pixels[static_cast<std::size_t>(y) * width + x]; }
  const glm::vec3& at(unsigned x, unsigned y) const { return pixels[static_cast<std::size_t>(y) * width + x]; }
};

/// By extension: .png (8 bit, clamped, floor(255 c + 0.5), no gamma), .exr (float RGB), .pfm (float RGB little-endian,
/// bottom row first). Written atomically. Throws Error.
/// Throws Error for a name that does not end in .png, .exr or .pfm.
void check_image_name(const std::string& path);
void write_image(const std::string& path, const Image& image);
/// Reads the same three formats (PNG values are byte / 255). Throws Error.
Image read_image(const std::string& path);

/// Result of comparing two images of equal size on values clamped to [0, 1].
struct Comparison {
  double psnr = 0.0;        ///< dB, peak 1; infinity when identical, NaN when a value is NaN in one image alone
  double max_error = 0.0;   ///< largest absolute channel difference, unclamped values
  double mean_error = 0.0;  ///< mean absolute channel difference, unclamped values
  std::size_t different_pixels = 0;  ///< pixels with any bit different
  bool identical() const { return different_pixels == 0; }
};
/// Throws Error when the sizes differ.
Comparison compare(const Image& a, const Image& b);

}  // namespace grtx::frontend
