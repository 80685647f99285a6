// SPDX-License-Identifier: Apache-2.0
#include "grtx/base/printable.h"

namespace grtx {
namespace {

/// Length in bytes of the first character of `text`; 0 if it is not valid UTF-8. Source: Unicode 15, table 3-7.
std::size_t bytes_of_first(std::string_view text) {
  const auto byte = [&text](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t bytes = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4) return 0;
  // The range of the second byte excludes overlong forms, surrogates, and code points beyond U+10FFFF.
  const unsigned least = first == 0xe0 ? 0xa0 : first == 0xf0 ? 0x90 : 0x80;
  const unsigned most = first == 0xed ? 0x9f : first == 0xf4 ? 0x8f : 0xbf;
  if (byte(1) < least || byte(1) > most) return 0;
  for (std::size_t i = 2; i < bytes; ++i) {
    if (byte(i) < 0x80 || byte(i) > 0xbf) return 0;
  }
  return bytes;
}

void append_escaped(std::string& shown, unsigned code) {
  shown += {'\\', 'x', "0123456789abcdef"[code >> 4], "0123456789abcdef"[code & 0xf]};
}

}  // namespace

std::string utf8(std::string_view text) {
  std::string shown;
  while (!text.empty()) {
    const std::size_t bytes = bytes_of_first(text);
    if (bytes == 0) {
      append_escaped(shown, static_cast<unsigned char>(text.front()));
    } else {
      shown += text.substr(0, bytes);
    }
    text.remove_prefix(bytes == 0 ? 1 : bytes);
  }
  return shown;
}

std::string printable(std::string_view text) {
  std::string shown;
  const std::string valid = utf8(text);
  for (std::size_t i = 0; i < valid.size(); ++i) {
    const auto c = static_cast<unsigned char>(valid[i]);
    // In UTF-8 the control characters U+0080 to U+009F are C2 80 to C2 9F.
    const auto next = static_cast<unsigned char>(i + 1 < valid.size() ? valid[i + 1] : 0);
    const bool of_two = c == 0xc2 && next < 0xa0;
    if (c >= 0x20 && c != 0x7f && !of_two) {
      shown += valid[i];
    } else if (c == '\n') {
      shown += "\\n";
    } else {
      append_escaped(shown, of_two ? next : c);
      i += of_two ? 1 : 0;
    }
  }
  return shown;
}

}  // namespace grtx
