// SPDX-License-Identifier: Apache-2.0
// What limits the meaning of a run's figures is said with them, and nothing is said where nothing does.
#include "grtx/rtl_tlm/run/result_notes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "grtx/base/error.h"

namespace grtx::sim {
namespace {

modules::StatisticList counted(double cycles, double tail, double fills, double dropped) {
  modules::StatisticList list;
  list.add("gpu.cycles", cycles, "cycles", "", modules::StatisticKind::count);
  list.add("gpu.distributor.tail_cycles", tail, "cycles", "", modules::StatisticKind::count);
  list.add("gpu.l1.fills", fills, "sectors", "", modules::StatisticKind::count);
  list.add("gpu.l1.fills_bypassed", dropped, "sectors", "", modules::StatisticKind::count);
  return list;
}

std::string printed(const std::map<std::string, ResultNotes>& notes) {
  testing::internal::CaptureStderr();
  print_notes(notes);
  return testing::internal::GetCapturedStderr();
}

constexpr std::uint64_t kAllSlots = 8 * 32;  ///< of the default machine

TEST(ResultNotes, AFullMachineWhoseRaysHitSaysNothing) {
  EXPECT_EQ(run_notes({}, {}, kAllSlots, counted(100, 10, 1000, 1)), ResultNotes());
  EXPECT_EQ(trace_notes({}, {.any_hit_calls = 1}), ResultNotes());
}

// Cameras of another scene: 747 cycles, speed-ups of 1.00 and "bit-identical" images, without a word.
TEST(ResultNotes, RaysThatMeetNoGaussian) {
  const ResultNotes notes = trace_notes({}, {.rays = 4096, .rounds = 4096, .visits_internal = 4096});
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes.front().id, "no-hits");
}

// 64 x 64 rays on eight SMs: the tail is the whole run, and so is what a speed-up compares.
TEST(ResultNotes, ALaunchThatDoesNotFillTheMachine) {
  const ResultNotes notes = run_notes({}, {}, 128, counted(200, 150, 0, 0));
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes.front(),
            (ResultNote{"partial-launch",
                        "a launch of 128 warps does not fill 256 warp slots, the machine is never full; after the last "
                        "warp has started, 75 % of the run is tail"}));
}

// Of walk, whose registers leave nine slots per SM, nothing was said of a run that was all tail.
TEST(ResultNotes, ALaunchThatFillsFewSlotsAndIsMostlyTail) {
  const ResultNotes notes = run_notes({}, {}, kAllSlots + 10, counted(200, 150, 0, 0));
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes.front(),
            (ResultNote{"partial-launch",
                        "a launch of 266 warps fills 256 warp slots for a short time only; after the last warp has "
                        "started, 75 % of the run is tail"}));
  EXPECT_TRUE(run_notes({}, {}, kAllSlots + 10, counted(200, 100, 0, 0)).empty());
}

TEST(ResultNotes, FramesAreLaunchedOneAfterTheOther) {
  traces::Header header;
  header.frame_groups = {128, 128, 128};
  ASSERT_EQ(run_notes({}, header, 384, counted(200, 50, 0, 0)).size(), 1u);
}

// The tail of the last frame was held against the cycles of all: alone it had the note, twice it had none.
TEST(ResultNotes, ASecondFrameDoesNotHideThatALaunchIsMostlyTail) {
  traces::Header header;
  header.frame_groups = {kAllSlots + 10, kAllSlots + 10};
  modules::StatisticList list = counted(400, 150, 0, 0);
  for (const char* frame : {"gpu.frame0.cycles", "gpu.frame1.cycles"}) {
    list.add(frame, 200.0, "cycles", "", modules::StatisticKind::largest);
  }
  const ResultNotes notes = run_notes({}, header, 2 * (kAllSlots + 10), list);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes.front(),
            (ResultNote{"partial-launch",
                        "a launch of 266 warps fills 256 warp slots for a short time only; after the last warp has "
                        "started, 75 % of the last frame is tail"}));
}

TEST(ResultNotes, RegistersLeaveFewerSlotsThanTheKeySays) {
  GpuConfig config = load_config("", {"simt.registers=24576", "simt.registers_per_thread=96"});
  ASSERT_EQ(config.resident(), 8u);
  const ResultNotes full = run_notes(config, {}, 64, {}), partial = run_notes(config, {}, 63, {});
  ASSERT_EQ(full.size(), 1u);
  EXPECT_EQ(full.front(),
            (ResultNote{"fewer-slots", "the registers of an SM hold 8 warps, not gpu.resident_warps = 32"}));
  ASSERT_EQ(partial.size(), 2u);
  EXPECT_EQ(partial.back().id, "partial-launch");
}

TEST(ResultNotes, HeapsThatTheRegistersDoNotHold) {
  const std::vector<std::string> heaps = {"rt.any_hit_unit.enabled=true", "simt.registers_per_thread=32",
                                          "simt.payload_registers=48"};
  traces::Header header;
  header.k = 16;
  EXPECT_THAT(run_notes(load_config("", heaps), header, 512, {}),
              ::testing::Each(::testing::Field(&ResultNote::id, "fewer-slots")));
  header.k = 17;
  EXPECT_EQ(run_notes(load_config("", heaps), header, 512, {}).back(),
            (ResultNote{"heap-registers",
                        "heaps of 17 hits need 51 registers of a thread, and simt.payload_registers = 48"}));
}

TEST(ResultNotes, AWarpThatRunsFurtherAheadThanItsTrace) {
  const GpuConfig config = load_config("", {"rt.traversal=warp", "rt.warp_stack.ahead=16"});
  traces::Header header;
  header.ahead = 16;
  EXPECT_TRUE(run_notes(config, header, 512, {}).empty());
  header.ahead = 1;
  ASSERT_EQ(run_notes(config, header, 512, {}).size(), 1u);
  EXPECT_EQ(run_notes(config, header, 512, {}).front().id, "ahead");
}

TEST(ResultNotes, CheckpointListsThatOverflow) {
  traces::Header header;
  header.checkpoint_capacity = 1;
  const ResultNotes notes = trace_notes(header, {.rounds = 5000, .any_hit_calls = 1, .overflows = 1207});
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes.front().id, "overflow");
  EXPECT_EQ(notes.front().text.substr(0, 49), "in 1207 of 5000 rounds a list of 1 checkpoints wa");
}

TEST(ResultNotes, MoreThanOneInAThousandFillsDropped) {
  const ResultNotes notes = run_notes({}, {}, kAllSlots, counted(100, 10, 1000, 2));
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes.front(), (ResultNote{"dropped-fills",
                                       "0.2 % of the fills of the L1 were dropped, their victims found no room: raise "
                                       "l1.write_back_buffer"}));
}

// Its statistics ended the whole run: "internal error: key not found".
TEST(ResultNotes, AnL1OfTheUsersThatDoesNotCountItsFillsSaysNothing) {
  EXPECT_EQ(run_notes({}, {}, kAllSlots, {}), ResultNotes());
}

TEST(ResultNotes, ALineForEachWithAllWhomItConcerns) {
  EXPECT_EQ(printed({}), "");
  EXPECT_EQ(printed({{"grtx", {{"a", "first"}}}, {"hw", {{"b", "second"}, {"a", "first"}}}}),
            "grtx: grtx, hw: first\ngrtx: hw: second\n");
}

TEST(ResultNotes, ReadBackAsTheyWereWritten) {
  const ResultNotes notes = {{"a", "first"}, {"b", "\"second\""}};
  EXPECT_EQ(notes_from(notes_json(notes), "s.json"), notes);
  for (const char* bad : {"{}", "[1]", R"([{"id":"a"}])", R"([{"id":"a","text":1}])"}) {
    EXPECT_THROW(notes_from(nlohmann::ordered_json::parse(bad), "s.json"), Error) << bad;
  }
}

}  // namespace
}  // namespace grtx::sim
