// SPDX-License-Identifier: Apache-2.0
// Inflating gzip and zstd streams of untrusted files into memory.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace grtx::frontend {

/// Largest expansion of deflate: bytes of output per byte of input.
inline constexpr std::size_t kMostInflation = 1032;

/// Inflates one gzip stream that fills `bytes` to its end. Memory grows with the actual output, not with the size that
/// a header claims. most: stops when the output has this many bytes. Throws Error with the byte in the compressed file.
std::string inflate_gzip(std::string_view bytes, std::size_t most, const std::string& file);

/// Inflates zstd frames that fill `bytes` and must give `plain_size` bytes. `begin`: the stream's offset in its file,
/// for errors.
std::string inflate_zstd(std::string_view bytes, std::size_t plain_size, std::size_t begin, const std::string& file);

}  // namespace grtx::frontend
