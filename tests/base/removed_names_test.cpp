// SPDX-License-Identifier: Apache-2.0
// Names of earlier versions lead to what is in their place.
#include "grtx/base/removed_names.h"

#include <gtest/gtest.h>

#include "grtx/base/nearest_name.h"

TEST(RemovedNames, HaveSomethingInTheirPlace) {
  EXPECT_EQ(grtx::in_place_of("--sample-engine"), "--mode windows");
  EXPECT_EQ(grtx::in_place_of("simt.private_store.entries"), "rt.any_hit_unit.enabled");
  EXPECT_EQ(grtx::in_place_of("fast.step"), "--mode cycle");
  EXPECT_EQ(grtx::said_of_removed("rt.checkpoint.forward"), "which was removed; in its place: --checkpoint-bins");
}

TEST(RemovedNames, AreNoOthers) {
  for (const char* name : {"", "fas", "simt.private_stores", "rt.checkpoint.forwards", "--mode"}) {
    EXPECT_EQ(grtx::in_place_of(name), "") << name;
    EXPECT_EQ(grtx::said_of_removed(name), "") << name;
  }
}

// The nearest of `modern` was `paper`, of `dense_indoor` `building`.
TEST(RemovedNames, ComeBeforeTheSmallestEditDistance) {
  EXPECT_EQ(grtx::nearest_name("modern", {"paper", "ada", "rdna4"}), "ada");
  EXPECT_EQ(grtx::nearest_name("dense_indoor", {"building", "hall"}), "hall");
  EXPECT_EQ(grtx::nearest_name("modern", {"paper", "modem"}), "modem") << "where what is in its place is not known";
}
