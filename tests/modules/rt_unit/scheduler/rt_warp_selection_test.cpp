// SPDX-License-Identifier: Apache-2.0
// Warp selection policies, without a kernel: which entry each chooses in a sequence of cycles.
#include "grtx/modules/rt_unit/scheduler/decide/warp_selection.h"

#include <gtest/gtest.h>

#include <bit>
#include <stdexcept>

#include "grtx/base/error.h"

namespace grtx::modules {
namespace {

struct Step {
  LaneMask candidates;
  std::vector<std::uint64_t> ages;
  unsigned expected;
};

/// Nobody asks of them.
struct NoWarps final : SelectableWarps {
  SelectableWarp at(unsigned) const override { return {}; }
};

void expect_choices(const char* policy, const std::vector<Step>& steps) {
  const auto selection = make_warp_selection(policy);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    EXPECT_EQ(selection->select(steps[i].candidates, steps[i].ages, NoWarps()), steps[i].expected)
        << policy << " step " << i;
  }
}

TEST(RtWarpSelection, OldestFirstTakesTheSmallestAgeAmongCandidates) {
  expect_choices("oldest_first", {{0b1111, {5, 2, 9, 4}, 1},
                                  {0b1101, {5, 2, 9, 4}, 3},
                                  {0b0100, {5, 2, 9, 4}, 2},
                                  {LaneMask{1} << 63, std::vector<std::uint64_t>(64, 1), 63}});
}

TEST(RtWarpSelection, RoundRobinGoesOnAfterTheLastAndWraps) {
  const std::vector<std::uint64_t> ages(64, 0);
  expect_choices("round_robin", {{0b1111, ages, 0},
                                 {0b1111, ages, 1},
                                 {0b1001, ages, 3},
                                 {0b1001, ages, 0},
                                 {LaneMask{1} << 63 | 1, ages, 63},
                                 {LaneMask{1} << 63 | 1, ages, 0}});
}

TEST(RtWarpSelection, GreedyStaysUntilItsWarpCannotGoOnThenTakesTheOldest) {
  expect_choices("greedy_then_oldest", {{0b111, {3, 1, 2}, 1},
                                        {0b111, {3, 1, 2}, 1},
                                        {0b101, {3, 1, 2}, 2},
                                        {0b111, {3, 1, 2}, 2},    // stays although 1 is older
                                        {0b111, {3, 1, 7}, 1}});  // entry 2 holds another warp now
}

/// The highest entry: made here, known by its name from then on.
class HighestEntry final : public WarpSelection {
 public:
  unsigned select(LaneMask candidates, const std::vector<std::uint64_t>&, const SelectableWarps&) override {
    return 63U - static_cast<unsigned>(std::countl_zero(candidates));
  }
};

TEST(RtWarpSelection, OneOfTheUsersIsRegisteredByName) {
  register_warp_selection("highest_entry", [] { return std::make_unique<HighestEntry>(); });
  expect_choices("highest_entry", {{0b0111, {1, 1, 1}, 2}, {0b0001, {1, 1, 1}, 0}});
  EXPECT_EQ(warp_selection_names().back(), "highest_entry");
  EXPECT_THROW(register_warp_selection("oldest_first", {}), std::logic_error);
}

TEST(RtWarpSelection, AFactoryThatMakesNothingIsNamed) {
  register_warp_selection("nothing", [] { return nullptr; });
  EXPECT_THROW(make_warp_selection("nothing"), Error);
}

TEST(RtWarpSelection, AnUnknownPolicyIsAnError) { EXPECT_THROW(make_warp_selection("newest"), Error); }

}  // namespace
}  // namespace grtx::modules
