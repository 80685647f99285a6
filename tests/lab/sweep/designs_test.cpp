// SPDX-License-Identifier: Apache-2.0
// The named designs: what each brings along fits together.
#include "grtx/lab/sweep/designs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "grtx/modules/messages/hit_heap.h"

namespace grtx::lab {
namespace {

std::string value_of(const Design::Texts& texts, const std::string& name) {
  for (const auto& [key, value] : texts) {
    if (key == name) return value;
  }
  return "";
}

TEST(Designs, HeapsHaveRegistersForTheirHits) {
  unsigned heaps = 0;
  for (const Design& design : designs()) {
    if (value_of(design.keys, "rt.any_hit_unit.enabled") != "true") continue;
    ++heaps;
    const unsigned words =
        static_cast<unsigned>(std::stoul(value_of(design.tracer, "k"))) * modules::HitHeap::kEntryWords;
    EXPECT_EQ(value_of(design.keys, "simt.payload_registers"), std::to_string(words)) << design.name;
  }
  EXPECT_EQ(heaps, 2u);
}

TEST(Designs, ThoseOfPapersAreComparedUnasked) {
  std::vector<std::string> unasked;
  for (const Design& design : designs()) {
    if (!design.if_named) unasked.push_back(design.name);
  }
  EXPECT_THAT(unasked, ::testing::ElementsAre("baseline", "sw", "hw", "grtx", "gautracer"));
}

TEST(Designs, WarpsThatWalkTogetherAreTracedWithAsManyNodesUnderWay) {
  const Design& walk = design_of("walk");
  EXPECT_EQ(value_of(walk.keys, "rt.traversal"), "warp");
  EXPECT_EQ(value_of(walk.keys, "rt.warp_stack.ahead"), value_of(walk.tracer, "ahead"));
}

}  // namespace
}  // namespace grtx::lab
