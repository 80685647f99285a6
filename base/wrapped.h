// SPDX-License-Identifier: Apache-2.0
// Wraps sentences to the width of a terminal.
#pragma once

#include <string>
#include <string_view>

namespace grtx {

/// Line width, in characters, of all tables and sentences that the program prints.
inline constexpr std::size_t kLineWidth = 80;

/// Replaces spaces in `text` by line breaks, so that lines have at most kLineWidth characters unless a word is longer.
/// Lines after the first begin with `indent` spaces. UTF-8: continuation bytes are not counted.
std::string wrapped(std::string_view text, std::size_t indent = 2);

}  // namespace grtx
