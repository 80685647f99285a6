// Which machine says that its L1 drops what it fetches.
#include "grtx/apps/grtx/dropped_fills.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace grtx::sim {
namespace {

std::string said(const nlohmann::ordered_json& statistics) {
  testing::internal::CaptureStderr();
  warn_of_dropped_fills(statistics, "hw");
  return testing::internal::GetCapturedStderr();
}

nlohmann::ordered_json counted(double fills, double dropped) {
  return {{"gpu.l1.fills", {{"value", fills}}}, {"gpu.l1.fills_bypassed", {{"value", dropped}}}};
}

TEST(DroppedFills, MoreThanOneInAThousandAreNamed) {
  EXPECT_EQ(said(counted(1000, 1)), "");
  EXPECT_EQ(said(counted(1000, 2)),
            "grtx: hw: 0.2 % of the fills of the L1 were dropped, their victims found no room: "
            "raise l1.write_back_buffer\n");
}

// Its statistics ended the whole run: "internal error: key not found".
TEST(DroppedFills, AnL1OfTheUsersThatDoesNotCountThemSaysNothing) {
  EXPECT_EQ(said({}), "");
  EXPECT_EQ(said({{"gpu.l1.fills", {{"value", 7}}}}), "");
}

}  // namespace
}  // namespace grtx::sim
