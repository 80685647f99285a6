// SPDX-License-Identifier: Apache-2.0
// The three image encodings on memory buffers; image.cpp chooses among them and does the file work.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/frontend/image/image.h"

namespace grtx::frontend {

/// Largest image that is read or written, pixels: a damaged header must not ask for all memory.
inline constexpr std::uint64_t kMaxImagePixels = std::uint64_t{1} << 26;

/// Encoders return the whole file; `path` names it in errors.
std::string encode_png(const std::string& path, const Image& image);
std::string encode_pfm(const Image& image);
std::string encode_exr(const std::string& path, const Image& image);

/// Decoders take the whole file; `path` names it in errors. Throw Error on damaged, truncated or unsupported content.
Image decode_png(const std::string& path, const std::string& bytes);
Image decode_pfm(const std::string& path, const std::string& bytes);
Image decode_exr(const std::string& path, const std::string& bytes);

}  // namespace grtx::frontend
