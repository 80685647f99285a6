// Inflating gzip and zstd streams of untrusted files into memory.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace grtx::frontend {

/// Most bytes that a byte of deflate stands for.
inline constexpr std::size_t kMostInflation = 1032;

/// One gzip stream that fills `bytes` to its end. Memory grows with what really comes out, not with what a header says.
/// most: it is left where so many bytes have come out. Throws Error with the byte in the compressed file.
std::string inflate_gzip(std::string_view bytes, std::size_t most, const std::string& file);

/// zstd frames that fill `bytes` and must give `plain_size` bytes. `begin`: byte of the stream in its file, for
/// messages.
std::string inflate_zstd(std::string_view bytes, std::size_t plain_size, std::size_t begin, const std::string& file);

}  // namespace grtx::frontend
