// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/image/image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/frontend/image/image_formats.h"

namespace grtx::frontend {
namespace {

enum class Format { png, pfm, exr };

Format format_of(const std::string& path) {
  const std::size_t slash = path.find_last_of('/');
  const std::size_t dot = path.find_last_of('.');
  std::string extension;
  if (dot != std::string::npos && (slash == std::string::npos || dot > slash)) extension = path.substr(dot);
  for (char& c : extension) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  if (extension == ".png") return Format::png;
  if (extension == ".pfm") return Format::pfm;
  if (extension == ".exr") return Format::exr;
  throw Error(path, "", "image files end in .png, .exr or .pfm");
}

/// Clamped to [0, 1]; NaN becomes 0 so that it counts as an error against every visible value.
double clamped(float value) { return value > 0.0f ? std::min(1.0, static_cast<double>(value)) : 0.0; }

}  // namespace

void check_image_name(const std::string& path) { format_of(path); }

void write_image(const std::string& path, const Image& image) {
  const Format format = format_of(path);
  const std::uint64_t count = std::uint64_t{image.width} * image.height;
  if (count == 0 || count > kMaxImagePixels || image.pixels.size() != count) {
    throw Error(path, "",
                fmt::format("an image has 1 to {} pixels, not {} x {}", kMaxImagePixels, image.width, image.height));
  }
  switch (format) {
    case Format::png:
      write_file(path, encode_png(path, image));
      return;
    case Format::pfm:
      write_file(path, encode_pfm(image));
      return;
    case Format::exr:
      write_file(path, encode_exr(path, image));
      return;
  }
}

Image read_image(const std::string& path) {
  const Format format = format_of(path);
  const std::string bytes = read_file(path);
  switch (format) {
    case Format::png:
      return decode_png(path, bytes);
    case Format::pfm:
      return decode_pfm(path, bytes);
    case Format::exr:
      return decode_exr(path, bytes);
  }
  return {};
}

Comparison compare(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height) {
    throw Error("image comparison", "",
                fmt::format("sizes must be equal, not {} x {} and {} x {}", a.width, a.height, b.width, b.height));
  }
  Comparison result;
  double sum_squared = 0.0;
  double sum_absolute = 0.0;
  bool undefined = false;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    bool different = false;
    for (int c = 0; c < 3; ++c) {
      const float x = a.pixels[i][c];
      const float y = b.pixels[i][c];
      if (std::memcmp(&x, &y, sizeof x) == 0) continue;
      different = true;
      double error = std::abs(static_cast<double>(x) - static_cast<double>(y));
      undefined = undefined || std::isnan(x) != std::isnan(y);
      if (std::isnan(error)) error = std::numeric_limits<double>::infinity();
      result.max_error = std::max(result.max_error, error);
      sum_absolute += error;
      const double visible = clamped(x) - clamped(y);
      sum_squared += visible * visible;
    }
    if (different) ++result.different_pixels;
  }
  const double channels = 3.0 * static_cast<double>(a.pixels.size());
  result.mean_error = a.pixels.empty() ? 0.0 : sum_absolute / channels;
  result.psnr = undefined            ? std::numeric_limits<double>::quiet_NaN()
                : sum_squared == 0.0 ? std::numeric_limits<double>::infinity()
                                     : -10.0 * std::log10(sum_squared / channels);
  return result;
}

}  // namespace grtx::frontend
