// Fast mode names what lies outside of where its error was measured, and nothing else.
#include "grtx/rtl_tlm/estimate/fast/measured_region.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace grtx::sim {
namespace {

TEST(MeasuredRegion, NamesKeysFarFromTheirDefaults) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{}, ""},
      {{"l2.latency=400", "rt.box.count=1", "dram.timing.refi=3333", "dram.timing.rfc=211", "gpu.sms=128"}, ""},
      {{"rt.box.interval=4"}, ""},
      {{"rt.box.interval=5"}, "rt.box.interval = 5"},
      {{"l2.latency=1"}, "l2.latency = 1"},
      {{"dram.timing.ccd=10000", "fast.stride=64"}, "dram.timing.ccd = 10000, fast.stride = 64"},
      {{"l2.line_bytes=256"}, "l2.line_bytes = 256"},  // a random machine with it was 8.7 % off without a word
      {{"l2.mshr_merges=1"}, "l2.mshr_merges = 1"},    // another 18 %
      {{"dram.timing.refi=500"}, "dram.timing.refi = 500"}};
  for (const auto& [settings, outside] : cases) {
    EXPECT_EQ(outside_of_measured(load_config("", settings), 128, 3'000'000), outside);
  }
  EXPECT_EQ(outside_of_measured({}, 127, 2'999'999), "a trace of 127 groups, 2999999 node visits");
  EXPECT_EQ(outside_notes("fast", ""), ResultNotes());
  EXPECT_EQ(outside_notes("fast", "this"),
            ResultNotes({{"outside-measured", "outside of what was measured for --mode fast: this"}}));
}

}  // namespace
}  // namespace grtx::sim
