// SPDX-License-Identifier: Apache-2.0
// Warp buffer: entries, lane states, the events of a round, occupancy, and the storage the paper counts.
#include "grtx/modules/rt_unit/warp_buffer/warp_buffer.h"

#include <gtest/gtest.h>

#include "modules/systemc_fixture.h"

namespace grtx::modules {
namespace {

class RtWarpBufferTest : public SystemCTest {};

/// Two rays with rounds of 3, 0 and 2 events, and of 1 event; event nodes are numbered.
traces::RayGroup two_rays() {
  traces::RayGroup group;
  group.rays.resize(2);
  const auto add = [](traces::Ray& ray, std::uint32_t events, bool replay) {
    traces::Round round;
    round.event_count = events;
    round.replay = replay;
    ray.rounds.push_back(round);
    for (std::uint32_t i = 0; i < events; ++i) {
      traces::Event event;
      event.node = static_cast<std::uint32_t>(ray.events.size());
      ray.events.push_back(event);
    }
  };
  add(group.rays[0], 3, false);
  add(group.rays[0], 0, true);
  add(group.rays[0], 2, true);
  add(group.rays[1], 1, false);
  return group;
}

TEST_F(RtWarpBufferTest, LanesFindTheEventsOfTheirRound) {
  const auto group = two_rays();
  WarpTable buffer(2);
  unsigned e = buffer.accept(0, {&group, 0, 7, 0b11});
  EXPECT_EQ(e, 0u);
  EXPECT_EQ(buffer.warp(e).in_state(LaneState::ready), 0b11u);
  EXPECT_EQ(buffer.warp(e).lane[0].next, group.rays[0].events.data());
  EXPECT_EQ(buffer.warp(e).lane[0].left, 3u);
  EXPECT_EQ(buffer.warp(e).lane[0].stack_depth, 1u);
  EXPECT_EQ(buffer.ready_entries(), 1u);
  EXPECT_EQ(buffer.find_slot(7), 0u);
  EXPECT_EQ(buffer.find_slot(8), buffer.entries());
  buffer.move(e, 0b01, LaneState::ready, LaneState::waiting_memory);
  EXPECT_EQ(buffer.ready_entries(), 1u);
  buffer.move(e, 0b10, LaneState::ready, LaneState::finished);
  EXPECT_EQ(buffer.ready_entries(), 0u);
  EXPECT_EQ(buffer.finished_entries(), 0u);
  EXPECT_EQ(buffer.warp(e).active(), 0b01u);
  buffer.move(e, 0b01, LaneState::waiting_memory, LaneState::finished);
  EXPECT_EQ(buffer.finished_entries(), 1u);
  buffer.release(10, e);
  EXPECT_TRUE(buffer.empty());

  e = buffer.accept(20, {&group, 1, 7, 0b01});  // round 1 has no events
  EXPECT_EQ(buffer.finished_entries(), 1u);
  buffer.release(21, e);
  e = buffer.accept(30, {&group, 2, 7, 0b01});  // offsets carried on from round 1
  EXPECT_EQ(buffer.warp(e).lane[0].next->node, 3u);
  EXPECT_EQ(buffer.warp(e).lane[0].stack_depth, 0u);
  e = buffer.accept(31, {&group, 2, 8, 0b01});  // another slot: summed from the start
  EXPECT_EQ(e, 1u);
  EXPECT_EQ(buffer.warp(e).lane[0].next->node, 3u);
  EXPECT_FALSE(buffer.has_room());
  buffer.settle(41);
  // 10 cycles, 1 cycle, then one warp from cycle 31 and two from cycle 32 to 40.
  EXPECT_EQ(buffer.counters().occupancy_integral, 10u + 1u + 1u + 2u * 9u);
}

TEST_F(RtWarpBufferTest, ACallOfARoundThatDoesNotExistIsRefused) {
  const auto group = two_rays();
  WarpTable buffer(2);
  EXPECT_THROW(buffer.accept(0, {&group, 1, 0, 0b10}), Error);
}

TEST_F(RtWarpBufferTest, OldestIsByAcceptanceNotByEntry) {
  const auto group = two_rays();
  WarpTable buffer(2);
  buffer.accept(0, {&group, 0, 0, 0b10});
  buffer.accept(1, {&group, 0, 1, 0b10});
  buffer.move(0, 0b10, LaneState::ready, LaneState::finished);
  buffer.release(5, 0);
  EXPECT_EQ(buffer.accept(6, {&group, 0, 2, 0b10}), 0u);
  EXPECT_EQ(buffer.oldest(buffer.occupied()), 1u);
}

// Paper, "Hardware cost": (1 bit + 2 B + 2 B) x 32 x warps + 8 B + 8 B + 2 B = 132 warps + 18 bytes.
TEST_F(RtWarpBufferTest, StorageForCheckpointingIs132WarpsPlus18Bytes) {
  for (const unsigned warps : {1u, 4u, 8u, 16u, 32u, 64u}) {
    const WarpBuffer buffer(("buffer" + std::to_string(warps)).c_str(), {warps, 8}, true,
                            stack_entry_layout(traces::PopTest::on));
    std::uint64_t bits = 0;
    for (const auto& s : buffer.inventory().storage) bits += s.added_by_grtx ? s.bits : 0;
    EXPECT_EQ(bits, 8 * (132 * warps + 18));
    if (warps == 8) {
      EXPECT_EQ(bits, 8 * 1074u);
    }
  }
}

std::uint64_t stack_bits(const WarpBuffer& buffer) {
  for (const auto& s : buffer.inventory().storage) {
    if (s.name == "stack") return s.bits;
  }
  return 0;
}

// A stack entry holds an address of 8 B, and with the test of popped nodes a t of 4 B.
TEST_F(RtWarpBufferTest, AStackEntryWithoutTTakesFourBytesLess) {
  const WarpBuffer with("with", {4, 8}, false, stack_entry_layout(traces::PopTest::on));
  const WarpBuffer without("without", {4, 8}, false, stack_entry_layout(traces::PopTest::off));
  EXPECT_EQ(stack_bits(with), 4u * 32 * 8 * 12 * 8);
  EXPECT_EQ(stack_bits(without), 4u * 32 * 8 * 8 * 8);
}

// A walk of 28 levels leaves all children of a node but one at each. The buffer had room for 140, whatever the width.
TEST_F(RtWarpBufferTest, AStackThatDoesNotSpillHasRoomForAWalkOfItsTreesWidth) {
  for (const auto& [width, entries] : {std::pair{8u, 28u * 7}, {6u, 28u * 5}, {2u, 28u * 5}}) {
    const WarpBuffer buffer(("wide" + std::to_string(width)).c_str(), {4, 8, false}, false,
                            stack_entry_layout(traces::PopTest::off), false, width);
    EXPECT_EQ(stack_bits(buffer), 4u * 32 * entries * 64);
  }
}

}  // namespace
}  // namespace grtx::modules
