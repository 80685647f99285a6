// SPDX-License-Identifier: Apache-2.0
#include "grtx/base/wrapped.h"

#include <algorithm>

namespace grtx {
namespace {

std::size_t characters(std::string_view text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xc0U) != 0x80U; }));
}

}  // namespace

std::string wrapped(std::string_view text, std::size_t indent) {
  std::string lines;
  std::size_t column = 0;
  while (!text.empty()) {
    // A word together with the spaces before it, so that columns in the first line keep their positions.
    const std::size_t word = std::min(text.find_first_not_of(' '), text.size());
    const std::size_t end = std::min(text.find(' ', word), text.size());
    const std::size_t width = characters(text.substr(0, end));
    if (column > 0 && word > 0 && column + width > kLineWidth) {
      lines += '\n' + std::string(indent, ' ');
      column = indent;
      text.remove_prefix(word);
    } else {
      lines += text.substr(0, end);
      column += width;
      text.remove_prefix(end);
      continue;
    }
    const std::size_t rest = std::min(text.find(' '), text.size());
    lines += text.substr(0, rest);
    column += characters(text.substr(0, rest));
    text.remove_prefix(rest);
  }
  return lines;
}

}  // namespace grtx
