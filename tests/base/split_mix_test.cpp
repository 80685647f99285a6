// SPDX-License-Identifier: Apache-2.0
// One sequence of random numbers for scenes, plans and windows: it never changes, or all of them would.
#include "grtx/base/split_mix.h"

#include <gtest/gtest.h>

namespace grtx {
namespace {

TEST(SplitMix, GivesTheNumbersOfTheReferenceProgram) {  // splitmix64.c of S. Vigna, seed 1234567
  SplitMix64 random(1234567);
  for (const std::uint64_t number : {6457827717110365317u, 3203168211198807973u, 9817491932198370423u,
                                     4593380528125082431u, 16408922859458223821u}) {
    EXPECT_EQ(random.next(), number);
  }
}

TEST(SplitMix, HashOfANumberIsTheFirstOfItsSequence) {
  for (const std::uint64_t seed : {std::uint64_t{0}, std::uint64_t{7}, ~std::uint64_t{0}}) {
    EXPECT_EQ(split_mix(seed), SplitMix64(seed).next());
  }
}

TEST(SplitMix, NumbersBelowABoundAndInTheUnitIntervalComeFromTheUpperBits) {
  SplitMix64 bits(9), bounded(9), unit(9);
  for (int i = 0; i < 1000; ++i) {
    const std::uint64_t next = bits.next();
    EXPECT_EQ(bounded.below(1000), (next >> 32) * 1000 >> 32);
    EXPECT_EQ(unit.uniform(), static_cast<double>(next >> 11) * 0x1p-53);
  }
}

}  // namespace
}  // namespace grtx
