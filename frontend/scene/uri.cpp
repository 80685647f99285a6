// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/scene/uri.h"

#include <array>
#include <charconv>

namespace grtx::frontend {

std::optional<std::string> decode_base64(std::string_view text) {
  if (text.size() % 4 != 0) return std::nullopt;
  const std::size_t padding = text.ends_with("==") ? 2 : text.ends_with("=") ? 1 : 0;
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::array<int, 256> value;
  value.fill(-1);
  for (std::size_t digit = 0; digit < kDigits.size(); ++digit)
    value[static_cast<unsigned char>(kDigits[digit])] = static_cast<int>(digit);
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3);
  unsigned bits = 0, word = 0;
  for (const char c : text.substr(0, text.size() - padding)) {
    const int digit = value[static_cast<unsigned char>(c)];
    if (digit < 0) return std::nullopt;
    word = word << 6 | static_cast<unsigned>(digit);
    bits += 6;
    if (bits >= 8) bytes += static_cast<char>(word >> (bits -= 8) & 0xffU);
  }
  return bytes;
}

std::string percent_decoded(const std::string& uri) {
  std::string path;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    unsigned byte = 0;
    if (uri[i] == '%' && i + 2 < uri.size() &&
        std::from_chars(uri.data() + i + 1, uri.data() + i + 3, byte, 16).ptr == uri.data() + i + 3) {
      path += static_cast<char>(byte);
      i += 2;
    } else {
      path += uri[i];
    }
  }
  return path;
}

}  // namespace grtx::frontend
