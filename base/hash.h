// SPDX-License-Identifier: Apache-2.0
// XXH3 hashes, which identify inputs and protect file chunks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace grtx {

std::uint64_t xxh3(const void* bytes, std::size_t count);
inline std::uint64_t xxh3(std::string_view text) { return xxh3(text.data(), text.size()); }
/// 16 lower-case hexadecimal digits.
std::string hex(std::uint64_t value);

}  // namespace grtx
