// SPDX-License-Identifier: Apache-2.0
// How many warps an SM holds: as many as its slots, or as the registers of their threads allow.
#include "grtx/modules/simt/decide/register_file.h"

#include <gtest/gtest.h>

#include "error_of.h"

namespace grtx::modules {
namespace {

TEST(RegisterFile, HoldsAsManyWarpsAsFit) {
  // registers / ((per thread + payload) x 32 lanes), rounded down.
  const struct {
    std::uint64_t registers;
    unsigned per_thread, payload;
    std::uint64_t warps;
  } cases[] = {
      {65536, 64, 0, 32},  {65536, 63, 0, 32},   {65536, 65, 0, 31},
      {65536, 64, 32, 21}, {65536, 255, 255, 4}, {2047, 64, 0, 0},
  };
  for (const auto& c : cases) {
    EXPECT_EQ((RegisterFile{c.registers, c.per_thread, c.payload}.warps()), c.warps)
        << c.registers << " registers, " << c.per_thread << " + " << c.payload;
  }
}

TEST(RegisterFile, LimitsNothingByDefault) {
  EXPECT_EQ(RegisterFile().warps(), ~std::uint64_t{0});
  EXPECT_EQ(RegisterFile().resident_warps(48), 48u);
}

TEST(RegisterFile, AnSmHasNoMoreWarpsThanSlots) {
  const RegisterFile file{65536, 64, 0};  // 32 warps
  EXPECT_EQ(file.resident_warps(16), 16u);
  EXPECT_EQ(file.resident_warps(32), 32u);
  EXPECT_EQ(file.resident_warps(48), 32u);
}

TEST(RegisterFile, SlotsAreThoseOfAMaskOfWarps) {
  for (const unsigned slots : {1u, 64u}) EXPECT_NO_THROW(check_resident_warps(slots));
  for (const unsigned slots : {0u, 65u}) {
    EXPECT_EQ(test::error_of([&] { check_resident_warps(slots); }), "configuration: resident_warps: must be 1 to 64");
  }
}

}  // namespace
}  // namespace grtx::modules
