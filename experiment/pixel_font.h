// SPDX-License-Identifier: Apache-2.0
// 5 x 7 pixel font for labels in pictures: letters (lower case is shown as capitals), digits and some punctuation.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace grtx::experiment {

inline constexpr unsigned kGlyphWidth = 5, kGlyphHeight = 7, kGlyphAdvance = 6;

/// Rows from the top, 5 bits each, the leftmost dot in the highest one. Unknown characters are blank.
constexpr std::array<std::uint8_t, kGlyphHeight> glyph(char c) {
  using Rows = std::array<std::uint8_t, kGlyphHeight>;
  constexpr Rows kDigits[10] = {{14, 17, 19, 21, 25, 17, 14}, {4, 12, 4, 4, 4, 4, 14},  {14, 17, 1, 6, 8, 16, 31},
                                {14, 17, 1, 6, 1, 17, 14},    {2, 6, 10, 18, 31, 2, 2}, {31, 16, 30, 1, 1, 17, 14},
                                {6, 8, 16, 30, 17, 17, 14},   {31, 1, 2, 4, 8, 8, 8},   {14, 17, 17, 14, 17, 17, 14},
                                {14, 17, 17, 15, 1, 2, 12}};
  constexpr Rows kLetters[26] = {
      {14, 17, 17, 31, 17, 17, 17}, {30, 17, 17, 30, 17, 17, 30}, {14, 17, 16, 16, 16, 17, 14},
      {30, 17, 17, 17, 17, 17, 30}, {31, 16, 16, 30, 16, 16, 31}, {31, 16, 16, 30, 16, 16, 16},
      {14, 17, 16, 23, 17, 17, 15}, {17, 17, 17, 31, 17, 17, 17}, {14, 4, 4, 4, 4, 4, 14},
      {7, 2, 2, 2, 2, 18, 12},      {17, 18, 20, 24, 20, 18, 17}, {16, 16, 16, 16, 16, 16, 31},
      {17, 27, 21, 21, 17, 17, 17}, {17, 25, 25, 21, 19, 19, 17}, {14, 17, 17, 17, 17, 17, 14},
      {30, 17, 17, 30, 16, 16, 16}, {14, 17, 17, 17, 21, 18, 13}, {30, 17, 17, 30, 20, 18, 17},
      {15, 16, 16, 14, 1, 1, 30},   {31, 4, 4, 4, 4, 4, 4},       {17, 17, 17, 17, 17, 17, 14},
      {17, 17, 17, 17, 17, 10, 4},  {17, 17, 17, 21, 21, 27, 17}, {17, 17, 10, 4, 10, 17, 17},
      {17, 17, 10, 4, 4, 4, 4},     {31, 1, 2, 4, 8, 16, 31}};
  if (c >= '0' && c <= '9') return kDigits[c - '0'];
  if (c >= 'a' && c <= 'z') return kLetters[c - 'a'];
  if (c >= 'A' && c <= 'Z') return kLetters[c - 'A'];
  switch (c) {
    case '.':
      return {0, 0, 0, 0, 0, 12, 12};
    case ',':
      return {0, 0, 0, 0, 12, 4, 8};
    case '\'':
      return {4, 4, 8, 0, 0, 0, 0};
    case '-':
      return {0, 0, 0, 31, 0, 0, 0};
    case '+':
      return {0, 4, 4, 31, 4, 4, 0};
    case '_':
      return {0, 0, 0, 0, 0, 0, 31};
    case '/':
      return {1, 1, 2, 4, 8, 16, 16};
    default:
      return {};
  }
}

}  // namespace grtx::experiment
