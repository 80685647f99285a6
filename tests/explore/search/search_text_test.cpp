// SPDX-License-Identifier: Apache-2.0
// How a search ends, in text: the front, the best of it, steps without effect, and limits for the page.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "grtx/explore/search/search.h"

namespace grtx::explore {
namespace {

using nlohmann::ordered_json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

ordered_json measured(double time, double area) { return {{"outcome", "measured"}, {"ratios", {time, area}}}; }

ordered_json result() {
  ordered_json result = {{"machine", "paper"},
                         {"screening", {{"mode", "cycle"}, {"scale", 1.0}, {"set", ordered_json::object()}}},
                         {"confirming", {{"mode", "cycle"}}},
                         {"objectives", {"gpu.time_us", "cost.mm2"}},
                         {"constraints", {"cost.mm2 <= 1.1 * reference", "gpu.time_us <= 500"}},
                         {"counts",
                          {{"candidates", 3},
                           {"space", 8.0},
                           {"generations", 1},
                           {"broken", 0},
                           {"too_dear", 0},
                           {"failed", 0},
                           {"screened", 3},
                           {"confirmed", 2},
                           {"front", 2}}},
                         {"reference", {{"confirming", {{{"scene", "room"}, {"view", 0}, {"values", {1000.0, 5.0}}}}}}},
                         {"front", {2, 0}},
                         {"effects", ordered_json::array()},
                         {"invalid", ordered_json::array()}};
  for (const auto& [time, area] : {std::pair(0.9, 0.8), std::pair(2.0, 2.0), std::pair(0.5, 1.05)}) {
    result["candidates"].push_back({{"coordinates", {{"l1.bytes", 65536}}}, {"confirming", measured(time, area)}});
  }
  const auto step = [](const char* key, ordered_json verdict) {
    verdict.update({{"key", key}, {"from", 1}, {"to", 2}});
    return verdict;
  };
  result["path"] = {step("l1.bytes", measured(0.6, 1.02)), step("l1.banks", measured(0.6, 1.02)),
                    step("l2.slices", measured(0.5, 1.05))};
  return result;
}

TEST(SearchText, TheFrontAndTheBestOfItStandLast) {
  const std::string text = search_text(result());
  const std::size_t path = text.find("from the reference to the first of the front"),
                    front = text.find("\nfront, over");
  ASSERT_NE(path, std::string::npos);
  EXPECT_GT(front, path);
  // Limits are absolute, and the reference's own values were nowhere.
  EXPECT_THAT(text.substr(front), HasSubstr("the reference has gpu.time_us 1000, cost.mm2 5\n"));
  EXPECT_THAT(text.substr(front),
              AllOf(HasSubstr("    candidate 2: l1.bytes=65536\n"),
                    HasSubstr("least gpu.time_us: candidate 2 (0.500), least cost.mm2: candidate 0 (0.800)")));
  ordered_json none = result();
  none["front"] = ordered_json::array();
  EXPECT_EQ(best_of_front(none), "");
}

// A step of 0.0 % stood as a bar of its own.
TEST(SearchText, StepsWithoutEffectAreNamedInOneLine) {
  const ordered_json searched = result();
  const ordered_json& path = searched.at("path");
  EXPECT_FALSE(is_idle_step(path, path[0]));
  EXPECT_TRUE(is_idle_step(path, path[1]));
  EXPECT_FALSE(is_idle_step(path, path[2]));
  const std::string text = search_text(searched);
  EXPECT_THAT(text, AllOf(HasSubstr("without effect, and left out: l1.banks: 1 → 2\n"), Not(HasSubstr("   l1.banks"))));
}

TEST(SearchText, ALimitIsOverTheReference) {
  ordered_json searched = result();
  EXPECT_EQ(limit_over_reference(searched, "cost.mm2"), 1.1);
  EXPECT_EQ(limit_over_reference(searched, "gpu.time_us"), 0.5);  // 500 of 1,000
  EXPECT_EQ(limit_over_reference(searched, "gpu.cycles"), std::nullopt);
  ordered_json& views = searched["reference"]["confirming"];
  views.push_back(views[0]);
  EXPECT_EQ(limit_over_reference(searched, "gpu.time_us"), std::nullopt);  // of which view?
}

}  // namespace
}  // namespace grtx::explore
