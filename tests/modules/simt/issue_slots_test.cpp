// SPDX-License-Identifier: Apache-2.0
// Issue slots: a scheduler issues one instruction per cycle, for the phases of its own warps in the order of their
// calls.
#include "grtx/modules/simt/decide/issue_slots.h"

#include <gtest/gtest.h>

namespace grtx::modules {
namespace {

constexpr unsigned kIssueSchedulers = 4, kIssueLatency = 6;

TEST(IssueSlots, APhaseBeginsInTheNextCycleAndEndsWithItsLastResult) {
  IssueSlots slots(kIssueSchedulers, kIssueLatency);
  constexpr Cycle kNow = 100;
  constexpr std::uint64_t kInstructions = 10;
  EXPECT_EQ(slots.reserve(0, kInstructions, kNow), kNow + 1 + kInstructions + kIssueLatency);
  EXPECT_EQ(slots.free_from(0), kNow + 1 + kInstructions);
  EXPECT_EQ(slots.busy_cycles(), kInstructions);
  EXPECT_EQ(slots.wait_cycles(), 0u);
}

TEST(IssueSlots, WarpsOfOneSchedulerWaitForEachOtherAndThoseOfAnotherDoNot) {
  IssueSlots slots(kIssueSchedulers, kIssueLatency);
  const Cycle first = slots.reserve(1, 10, 0);
  EXPECT_EQ(slots.reserve(1 + kIssueSchedulers, 5, 0), first + 5);  // the same scheduler
  EXPECT_EQ(slots.wait_cycles(), 10u);
  EXPECT_EQ(slots.reserve(2, 5, 0), Cycle{1 + 5 + kIssueLatency});  // another
  EXPECT_EQ(slots.wait_cycles(), 10u);
  EXPECT_EQ(slots.busy_cycles(), 20u);
}

TEST(IssueSlots, ASchedulerThatIsFreeAgainMakesNobodyWait) {
  IssueSlots slots(1, kIssueLatency);
  slots.reserve(0, 3, 0);                                           // free from cycle 4 on
  EXPECT_EQ(slots.reserve(5, 1, 3), Cycle{4 + 1 + kIssueLatency});  // begins in cycle 4, as it would by itself
  EXPECT_EQ(slots.reserve(0, 1, 20), Cycle{21 + 1 + kIssueLatency});
  EXPECT_EQ(slots.wait_cycles(), 0u);
}

TEST(IssueSlots, APhaseWithoutInstructionsTakesNoCycleOfTheScheduler) {
  IssueSlots slots(1, kIssueLatency);
  EXPECT_EQ(slots.reserve(0, 0, 9), Cycle{10 + kIssueLatency});
  EXPECT_EQ(slots.reserve(1, 2, 9), Cycle{10 + 2 + kIssueLatency});
  EXPECT_EQ(slots.busy_cycles(), 2u);
}

}  // namespace
}  // namespace grtx::modules
