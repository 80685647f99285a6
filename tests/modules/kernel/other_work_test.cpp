// Cycles that other work takes: its share of them, each drawn by itself, the same in every run.
#include "grtx/modules/kernel/other_work.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "grtx/modules/simt/decide/issue_slots.h"

namespace grtx::modules {
namespace {

constexpr Cycle kCycles = 200'000;

double taken(const OtherWork& work) {
  double cycles = 0;
  for (Cycle c = 0; c < kCycles; ++c) cycles += work.takes(c) ? 1 : 0;
  return cycles / kCycles;
}

TEST(OtherWork, TakesItsShare) {
  for (const double share : {0.05, 0.3, 0.5, 0.9}) {
    for (const SharedResource resource : {SharedResource::issue, SharedResource::l1, SharedResource::dram}) {
      for (const unsigned unit : {0U, 1U, 70U}) {
        const double sigma = std::sqrt(share * (1 - share) / kCycles);
        EXPECT_NEAR(taken(OtherWork(share, resource, unit)), share, 5 * sigma) << share << " of unit " << unit;
      }
    }
  }
}

TEST(OtherWork, AShareOfZeroTakesNothing) {
  const OtherWork none(0.0, SharedResource::l1, 3);
  EXPECT_FALSE(none);
  EXPECT_EQ(taken(none), 0.0);
  EXPECT_EQ(none.free_from(17), 17U);
  EXPECT_EQ(none.last_of(17, 5), 21U);
}

// Neighbouring cycles, and units, know nothing of each other.
TEST(OtherWork, DrawsEachCycleAndUnitByItself) {
  const double share = 0.5, sigma = std::sqrt(0.25 * 0.75 / kCycles);
  const OtherWork a(share, SharedResource::issue, 0);
  for (const OtherWork& b : {OtherWork(share, SharedResource::issue, 1), OtherWork(share, SharedResource::l1, 0)}) {
    double both = 0, in_turn = 0;
    for (Cycle c = 0; c < kCycles; ++c) {
      both += a.takes(c) && b.takes(c) ? 1 : 0;
      in_turn += a.takes(c) && a.takes(c + 1) ? 1 : 0;
    }
    EXPECT_NEAR(both / kCycles, 0.25, 5 * sigma);
    EXPECT_NEAR(in_turn / kCycles, 0.25, 8 * sigma);
  }
}

TEST(OtherWork, CountsTheCyclesThatItLeaves) {
  const OtherWork work(0.7, SharedResource::dram, 2);
  for (const Cycle from : {0U, 1U, 99U}) {
    std::vector<Cycle> left;
    for (Cycle c = from; left.size() < 20; ++c) {
      if (!work.takes(c)) left.push_back(c);
    }
    EXPECT_EQ(work.free_from(from), left[0]);
    for (unsigned n = 1; n <= 20; ++n) EXPECT_EQ(work.last_of(from, n), left[n - 1]);
  }
}

TEST(IssueSlotsWithOtherWork, TakeLongerByOneOverWhatIsLeft) {
  constexpr std::uint64_t kInstructions = 50'000;
  for (const double share : {0.0, 0.2, 0.5, 0.9}) {
    IssueSlots slots(2, 4, share, 5);
    Cycle ready = 0;
    for (unsigned phase = 0; phase < 10; ++phase) ready = slots.reserve(7, kInstructions / 10, 99);
    const auto cycles = static_cast<double>(ready - 4 - 100);
    EXPECT_NEAR(cycles * (1 - share), kInstructions, share == 0.0 ? 0.0 : 0.02 * kInstructions) << share;
    EXPECT_EQ(slots.busy_cycles(), kInstructions);
    EXPECT_EQ(slots.free_from(6), 0U) << "the other scheduler";
  }
}

TEST(IssueSlotsWithOtherWork, WaitIsAllThatIsNoInstruction) {
  const OtherWork work(0.5, SharedResource::issue, 64 * 3 + 1);
  IssueSlots slots(2, 4, 0.5, 3);
  const Cycle last = work.last_of(11, 6);
  EXPECT_EQ(slots.reserve(1, 6, 10), last + 1 + 4);
  EXPECT_EQ(slots.wait_cycles(), last + 1 - 6 - 11);
  EXPECT_EQ(slots.reserve(1, 0, 10), last + 1 + 4) << "a phase without instructions takes no slot";
}

}  // namespace
}  // namespace grtx::modules
