// SPDX-License-Identifier: Apache-2.0
// The effect of a write on the L1, by region, policy and whether its line is there.
#include "grtx/modules/cache/decide/write_policy.h"

#include <gtest/gtest.h>

namespace grtx::modules {
namespace {

constexpr auto kThrough = WritePolicy::write_through;
constexpr auto kBack = WritePolicy::write_back;

TEST(L1WritePolicy, SharedRegionsAreWrittenThroughAndNeverKept) {
  for (const WritePolicy policy : {kThrough, kBack}) {
    for (const bool allocate : {false, true}) {
      for (const bool present : {false, true}) {
        const auto effect = PrivateWrites{policy, allocate}.effect(Region::ray, present);
        EXPECT_FALSE(effect.keep);
        EXPECT_FALSE(effect.dirty);
        EXPECT_TRUE(effect.forward);
      }
    }
  }
}

TEST(L1WritePolicy, PrivateRegionsFollowThePolicy) {
  const struct {
    WritePolicy policy;
    bool allocate, present;
    bool keep, dirty, forward;
  } cases[] = {
      {kThrough, false, false, false, false, true}, {kThrough, false, true, false, false, true},
      {kThrough, true, false, true, false, true},   {kThrough, true, true, true, false, true},
      {kBack, false, false, false, false, true},  // nothing to write into: on to the L2
      {kBack, false, true, true, true, false},      {kBack, true, false, true, true, false},
      {kBack, true, true, true, true, false},
  };
  for (const auto& c : cases) {
    const auto effect = PrivateWrites{c.policy, c.allocate}.effect(Region::stack, c.present);
    const auto what = ::testing::Message()
                      << name_of(c.policy) << " allocate " << c.allocate << " present " << c.present;
    EXPECT_EQ(effect.keep, c.keep) << what;
    EXPECT_EQ(effect.dirty, c.dirty) << what;
    EXPECT_EQ(effect.forward, c.forward) << what;
  }
}

TEST(L1WritePolicy, AWriteIsEitherDirtyHereOrOnItsWayToTheL2) {
  for (const Region region : {Region::stack, Region::checkpoint, Region::ray}) {
    for (const WritePolicy policy : {kThrough, kBack}) {
      for (const bool allocate : {false, true}) {
        for (const bool present : {false, true}) {
          const auto effect = PrivateWrites{policy, allocate}.effect(region, present);
          EXPECT_NE(effect.dirty, effect.forward);
        }
      }
    }
  }
}

}  // namespace
}  // namespace grtx::modules
