// SPDX-License-Identifier: Apache-2.0
// The bits of binary16 and the bytes of colours against their definitions.
#include "grtx/base/fp16.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "grtx/base/colour_byte.h"

namespace grtx {
namespace {

/// The value of 16 bits, as IEEE 754 has it.
float value_of(unsigned bits) {
  const int exponent = static_cast<int>(bits >> 10 & 31);
  const float fraction = static_cast<float>(bits & 1023);
  const float magnitude = exponent == 31  ? std::numeric_limits<float>::infinity()
                          : exponent == 0 ? std::ldexp(fraction, -24)
                                          : std::ldexp(1024.0f + fraction, exponent - 25);
  return (bits & 0x8000) != 0 ? -magnitude : magnitude;
}

TEST(Fp16, BitsAreThoseOfEachValue) {
  for (unsigned bits = 0; bits < 0x10000; ++bits) {
    if ((bits & 0x7C00) == 0x7C00 && (bits & 1023) != 0) continue;  // NaN
    if (bits == 0x8000) continue;                                   // -0 becomes 0
    EXPECT_EQ(fp16_bits(value_of(bits)), bits) << bits;
  }
  EXPECT_EQ(fp16_bits(std::nanf("")), 0x7E00u);
}

TEST(Fp16, BitsOfWhatLiesBetweenAreThoseOfTheNearest) {
  EXPECT_EQ(fp16_bits(1.0f + 0x1p-11f), fp16_bits(1.0f));  // a tie, to even
  EXPECT_EQ(fp16_bits(1.0f + 0x1.8p-11f), fp16_bits(1.0f + 0x1p-10f));
  EXPECT_EQ(fp16_bits(0x1p-25f), 0u);
  EXPECT_EQ(fp16_bits(0x1.8p-25f), 1u);
  EXPECT_EQ(fp16_bits(70000.0f), 0x7C00u);
}

TEST(ColourByte, RoundsAndClamps) {
  EXPECT_EQ(colour_byte(-1.0f), 0);
  EXPECT_EQ(colour_byte(std::nanf("")), 0);
  EXPECT_EQ(colour_byte(0.5f / 255.0f), 1);
  EXPECT_EQ(colour_byte(0.49f / 255.0f), 0);
  EXPECT_EQ(colour_byte(254.0f / 255.0f), 254);
  EXPECT_EQ(colour_byte(2.0f), 255);
}

}  // namespace
}  // namespace grtx
