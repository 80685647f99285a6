// Suggestions pick the smallest edit distance.
#include "grtx/base/nearest_name.h"

#include <gtest/gtest.h>

TEST(NearestName, PicksTheSmallestEditDistance) {
  const std::vector<std::string> known = {"tri20", "tri80", "tlas-tri20"};
  EXPECT_EQ(grtx::nearest_name("tri2", known), "tri20");
  EXPECT_EQ(grtx::nearest_name("tls-tri20", known), "tlas-tri20");
  EXPECT_EQ(grtx::nearest_name("x", {}), "");
}
