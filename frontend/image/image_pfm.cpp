// SPDX-License-Identifier: Apache-2.0
// Portable float map: "PF", size, scale -1 (little-endian), then rows from the bottom up.
#include <fmt/format.h>

#include <bit>
#include <cstring>

#include "grtx/base/error.h"
#include "grtx/frontend/image/image_formats.h"

namespace grtx::frontend {
namespace {

static_assert(std::endian::native == std::endian::little, "PFM files are written little-endian");

/// The next run of non-space characters; moves `at` behind it.
std::string token(const std::string& bytes, std::size_t& at) {
  constexpr std::size_t kLongest = 32;  // no header field is longer; binary data without spaces must not be scanned
  while (at < bytes.size() && (bytes[at] == ' ' || bytes[at] == '\n' || bytes[at] == '\r' || bytes[at] == '\t')) ++at;
  const std::size_t start = at;
  while (at < bytes.size() && static_cast<unsigned char>(bytes[at]) > ' ' && at - start < kLongest) ++at;
  return bytes.substr(start, at - start);
}

unsigned dimension(const std::string& path, const std::string& text) {
  unsigned value = 0;
  for (const char c : text) {
    if (c < '0' || c > '9' || value > kMaxImagePixels / 10)
      throw Error(path, "header", "width and height must be positive integers");
    value = value * 10 + static_cast<unsigned>(c - '0');
  }
  if (value == 0) throw Error(path, "header", "width and height must be positive integers");
  return value;
}

}  // namespace

std::string encode_pfm(const Image& image) {
  std::string bytes = fmt::format("PF\n{} {}\n-1.0\n", image.width, image.height);
  const std::size_t row_bytes = std::size_t{image.width} * sizeof(glm::vec3);
  static_assert(sizeof(glm::vec3) == 12);
  for (unsigned y = image.height; y-- > 0;) {
    bytes.append(reinterpret_cast<const char*>(&image.at(0, y)), row_bytes);
  }
  return bytes;
}

Image decode_pfm(const std::string& path, const std::string& bytes) {
  std::size_t at = 0;
  const std::string magic = token(bytes, at);
  if (magic != "PF" && magic != "Pf") throw Error(path, "byte 0", "must start with PF (colour) or Pf (grey)");
  const std::size_t channels = magic == "PF" ? 3 : 1;
  const unsigned width = dimension(path, token(bytes, at));
  const unsigned height = dimension(path, token(bytes, at));
  const std::string scale_text = token(bytes, at);
  char* end = nullptr;
  const double scale = std::strtod(scale_text.c_str(), &end);
  if (scale_text.empty() || *end != '\0' || !(scale < 0.0 || scale > 0.0)) {
    throw Error(path, "header", "the scale must be a number other than 0");
  }
  if (std::uint64_t{width} * height > kMaxImagePixels) {
    throw Error(path, "header", fmt::format("has more than {} pixels", kMaxImagePixels));
  }
  if (at >= bytes.size()) throw Error(path, fmt::format("byte {}", at), "ends before the pixels");
  ++at;  // exactly one white-space byte after the scale
  const std::size_t need = std::size_t{width} * height * channels * sizeof(float);
  if (bytes.size() - at != need) {
    throw Error(path, fmt::format("byte {}", at),
                fmt::format("must hold {} bytes of pixels, has {}", need, bytes.size() - at));
  }
  const bool swap = scale > 0.0;  // a positive scale says big-endian
  Image image(width, height);
  for (unsigned y = height; y-- > 0;) {
    for (unsigned x = 0; x < width; ++x) {
      for (std::size_t c = 0; c < channels; ++c) {
        std::uint32_t word = 0;
        std::memcpy(&word, bytes.data() + at, sizeof word);
        at += sizeof word;
        if (swap) word = (word >> 24) | ((word >> 8) & 0xff00u) | ((word << 8) & 0xff0000u) | (word << 24);
        image.at(x, y)[static_cast<int>(c)] = std::bit_cast<float>(word);
      }
      if (channels == 1) image.at(x, y) = glm::vec3(image.at(x, y).x);
    }
  }
  return image;
}

}  // namespace grtx::frontend
