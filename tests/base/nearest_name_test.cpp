// SPDX-License-Identifier: Apache-2.0
// Suggestions pick the smallest edit distance.
#include "grtx/base/nearest_name.h"

#include <gtest/gtest.h>

TEST(NearestName, PicksTheSmallestEditDistance) {
  const std::vector<std::string> known = {"tri20", "tri80", "tlas-tri20"};
  EXPECT_EQ(grtx::nearest_name("tri2", known), "tri20");
  EXPECT_EQ(grtx::nearest_name("tls-tri20", known), "tlas-tri20");
  EXPECT_EQ(grtx::nearest_name("x", {}), "");
}

TEST(NearestName, OfEquallyNearOnesIsTheFirst) {
  EXPECT_EQ(grtx::nearest_name("b", {"abc", "ab", "bc", "b1"}), "ab");
  EXPECT_EQ(grtx::nearest_name("l1.latncy", {"l2.latency", "l1.ways", "l1.latency", "l1.lat"}), "l1.latency");
}

TEST(NearestName, OfNeighboursSwappedIsTheOneThatWasMeant) {
  EXPECT_EQ(grtx::nearest_name("rnu", {"ray", "run"}), "run");
  EXPECT_EQ(grtx::nearest_name("sacle", {"scene", "scale"}), "scale");
}

TEST(NearestName, OfAVeryLongNameIsThatOfItsBeginning) {
  const std::vector<std::string> known = {"scene", "l1.latency", "set"};
  EXPECT_EQ(grtx::nearest_name("l1.latency" + std::string(1000000, 'x'), known), "l1.latency");
}

// "rt.stack.entries" named the key of another design alone.
TEST(NearestName, OfAKeyAreAlsoThoseWithAllOfItsWords) {
  const std::vector<std::string> known = {"rt.warp_stack.entries", "rt.warp_buffer.entries",
                                          "rt.warp_buffer.stack_entries"};
  EXPECT_EQ(grtx::nearest_keys("rt.stack.entries", known),
            "the nearest are 'rt.warp_stack.entries' and 'rt.warp_buffer.stack_entries'");
  EXPECT_EQ(grtx::nearest_keys("rt.warp_bufer.entries", known), "the nearest is 'rt.warp_buffer.entries'");
  EXPECT_EQ(grtx::nearest_keys("entries", known), "the nearest is 'rt.warp_stack.entries'");
}
