// SPDX-License-Identifier: Apache-2.0
// The named designs: what each brings along fits together.
#include "grtx/explore/sweep/designs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "error_of.h"
#include "grtx/modules/messages/hit_heap.h"

namespace grtx::explore {
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
    const bool has_heaps = value_of(design.keys, "rt.any_hit_unit.enabled") == "true";
    heaps += has_heaps ? 1 : 0;
    for (const unsigned k : {k_of(design), 8U, 48U}) {
      EXPECT_EQ(value_of(keys_for(design, k), "simt.payload_registers"),
                has_heaps ? std::to_string(k * modules::HitHeap::kEntryWords) : "")
          << design.name;
    }
  }
  EXPECT_EQ(heaps, 2u);
  EXPECT_EQ(value_of(keys_for(design_of("walk"), 128), "simt.payload_registers"), "255");  // what a thread can have
}

TEST(Designs, AnUnknownOneIsNamedWithTheNearest) {
  const std::string fault = grtx::test::error_of([] { design_of("wlak"); });
  EXPECT_TRUE(fault.starts_with("design: wlak: must be one of baseline")) << fault;
  EXPECT_TRUE(fault.ends_with("the nearest is 'walk'")) << fault;
}

TEST(Designs, KOfATextOrItsOwn) {
  EXPECT_EQ(k_of(design_of("walk")), 64u);
  EXPECT_EQ(k_of(design_of("walk"), "16"), 16u);
  EXPECT_EQ(k_of(design_of("walk"), "many"), 64u);
  EXPECT_EQ(k_of(design_of("grtx")), 16u);
}

// The baseline and grtx had 8 beside walk's 64, whatever was fastest for them.
TEST(Designs, EachHasTheKThatIsRecommendedForIt) {
  std::map<std::string, unsigned> k;
  for (const Design& design : designs()) k[design.name] = k_of(design);
  EXPECT_EQ(k, (std::map<std::string, unsigned>{
                   {"baseline", 32}, {"sw", 32}, {"hw", 16}, {"grtx", 16}, {"gautracer", 48}, {"walk", 64}}));
}

TEST(Designs, WarpsThatWalkTogetherAreTracedWithAsManyNodesUnderWay) {
  const Design& walk = design_of("walk");
  EXPECT_EQ(value_of(walk.keys, "rt.traversal"), "warp");
  EXPECT_EQ(value_of(walk.keys, "rt.warp_stack.ahead"), value_of(walk.tracer, "ahead"));
  EXPECT_EQ(value_of(walk.keys, "rt.warp_stack.entries"), "96");  // rt_unit_warp_walk_test.cpp: why not the key's 64
}

}  // namespace
}  // namespace grtx::explore
