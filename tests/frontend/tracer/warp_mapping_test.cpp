// SPDX-License-Identifier: Apache-2.0
// How pixels form warps: every pixel once, warps of the size and shape asked for.
#include <gtest/gtest.h>

#include <set>

#include "grtx/base/error.h"
#include "grtx/frontend/tracer/tracer.h"

namespace grtx::frontend {
namespace {

struct Shape {
  unsigned warp_size, width, height;
};

TEST(WarpMapping, EveryPixelIsInOneWarp) {
  for (const unsigned warp_size : {4U, 8U, 16U, 32U}) {
    for (const bool linear : {false, true}) {
      const auto groups = map_pixels(37, 13, linear, warp_size);
      std::set<std::uint32_t> seen;
      for (const auto& group : groups) {
        EXPECT_GE(group.size(), 1U);
        EXPECT_LE(group.size(), warp_size);
        for (const std::uint32_t pixel : group) EXPECT_TRUE(seen.insert(pixel).second) << pixel;
      }
      EXPECT_EQ(seen.size(), 37U * 13);
    }
  }
}

TEST(WarpMapping, TilesHaveTheirShape) {
  for (const Shape& shape : {Shape{32, 8, 4}, Shape{16, 4, 4}, Shape{8, 4, 2}, Shape{4, 2, 2}}) {
    const auto groups = map_pixels(64, 32, false, shape.warp_size);
    EXPECT_EQ(groups.size(), 64U * 32 / shape.warp_size);
    for (unsigned lane = 0; lane < shape.warp_size; ++lane) {
      EXPECT_EQ(groups[1][lane], lane / shape.width * 64 + shape.width + lane % shape.width) << shape.warp_size;
    }
  }
}

TEST(WarpMapping, LinearWarpsAreRuns) {
  const auto groups = map_pixels(10, 3, true, 8);
  ASSERT_EQ(groups.size(), 4U);
  EXPECT_EQ(groups[1], (std::vector<std::uint32_t>{8, 9, 10, 11, 12, 13, 14, 15}));
  EXPECT_EQ(groups[3].size(), 6U);
}

TEST(WarpMapping, OtherSizesAreRefused) {
  for (const unsigned warp_size : {0U, 1U, 12U, 64U}) EXPECT_THROW(map_pixels(8, 8, true, warp_size), Error);
}

}  // namespace
}  // namespace grtx::frontend
