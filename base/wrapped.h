// Sentences on lines of a terminal's width.
#pragma once

#include <string>
#include <string_view>

namespace grtx {

/// Characters of a line of every table and sentence that the program prints.
inline constexpr std::size_t kLineWidth = 80;

/// `text` with line breaks in place of spaces, so that no line is wider than kLineWidth characters where its words
/// allow it; lines after the first begin with `indent` spaces. UTF-8: what goes on a character is not counted.
std::string wrapped(std::string_view text, std::size_t indent = 2);

}  // namespace grtx
