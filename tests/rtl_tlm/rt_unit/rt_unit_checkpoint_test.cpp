// SPDX-License-Identifier: Apache-2.0
// Checkpoint traffic: which sectors are written and read, in which cycles, and that replay needs no traversal from the
// root.
#include <gmock/gmock.h>

#include "grtx/base/error.h"
#include "rtl_tlm/rt_unit/rt_bench.h"

namespace grtx::sim {
namespace {

using namespace test;
using modules::Region;

class RtUnitCheckpointTest : public modules::SystemCTest {};

constexpr Cycle kFirstVisit = 2;
constexpr Cycle kBoxTest = 2 + 20 + 1 + 13;
constexpr std::uint64_t kCapacity = 64;  // 1280 B a buffer: every buffer begins on a sector boundary

/// A lane's open sector and the sector that it has read last are held in the unit.
BenchOptions with_sector_buffers() {
  BenchOptions options;
  options.rt.checkpoint.write_combine = true;
  options.rt.checkpoint.read_buffer = true;
  return options;
}

/// Written or read on demand.
std::vector<std::uint64_t> addresses(const RtBench& bench, bool write) {
  std::vector<std::uint64_t> list;
  for (const auto& r : bench.requests[1]) {
    EXPECT_EQ(r.request.region, Region::checkpoint);
    EXPECT_EQ(r.request.address % 32, 0u);
    if (r.request.write == write && !r.request.prefetch) list.push_back(r.request.address);
  }
  return list;
}

/// One ray: round 0 checkpoints `entries` children (at most 6 per node), round 1 takes all of them as leaves that miss.
traces::RayGroup write_then_replay(unsigned entries) {
  traces::RayGroup group;
  group.nodes = {node_definition(1, 10, std::vector<NodeKind>(6, NodeKind::internal)),
                 node_definition(10, 20, std::vector<NodeKind>(6, NodeKind::triangle))};
  group.rays.resize(1);
  std::vector<Event> first, second;
  for (unsigned left = entries, node = 0; left > 0; node = 1) {
    const unsigned here = std::min(left, 5u);
    left -= here;
    first.push_back(internal_event(node, left > 0 ? 0b100000 : 0, (1u << here) - 1));
    // Every further visit is of node 1 again: the traffic depends on the masks only.
  }
  for (unsigned i = 0; i < entries; ++i) {
    second.push_back(take_event(20 + i % 6));
    second.push_back(leaf_event(20 + i % 6, LeafOutcome::miss));
  }
  add_round(group.rays[0], first);
  add_round(group.rays[0], second, true);
  return group;
}

TEST_F(RtUnitCheckpointTest, EachSectorOfAPassIsWrittenAndReadOnce) {
  for (const unsigned entries : {1u, 2u, 3u, 5u, 8u, 11u, 16u, 40u}) {
    SCOPED_TRACE(entries);
    const auto group = write_then_replay(entries);
    RtBench bench(small_header("tri20", kCapacity), with_sector_buffers());
    bench.run(group, 3);
    const std::uint64_t base = bench.map().checkpoint_entry(bench.map().ray_slot(0, 3, 0), 0, 0);
    const std::uint64_t sectors = (entries * 20 + 31) / 32;
    std::vector<std::uint64_t> expected;
    for (std::uint64_t s = 0; s < sectors; ++s) expected.push_back(base + 32 * s);
    EXPECT_EQ(addresses(bench, true), expected);
    EXPECT_EQ(addresses(bench, false), expected);  // round 1 reads what round 0 wrote
    const auto c = bench.counters().checkpoint;
    EXPECT_EQ(c.entries_written, entries);
    EXPECT_EQ(c.entries_read, entries);
    EXPECT_EQ(c.acknowledged, sectors);
    EXPECT_EQ(c.returned, sectors);
    EXPECT_EQ(c.max_entries, entries);
    // Four of eight consecutive entries (160 B = 5 sectors) lie in two sectors: 1, 3, 4 and 6.
    std::uint64_t straddling = 0;
    for (unsigned i = 0; i < entries; ++i) straddling += (i * 20) / 32 != (i * 20 + 19) / 32 ? 1 : 0;
    EXPECT_EQ(c.straddling_written, straddling);
    EXPECT_EQ(c.straddling_read, straddling);
    if (entries == 8) {
      EXPECT_EQ(straddling, 4u);
    }
  }
}

TEST_F(RtUnitCheckpointTest, WithoutBuffersEveryTouchedSectorIsTraffic) {
  BenchOptions options;
  options.rt.checkpoint.write_combine = false;
  options.rt.checkpoint.read_buffer = false;
  const auto group = write_then_replay(8);
  RtBench bench(small_header("tri20", kCapacity), options);
  bench.run(group);
  const auto c = bench.counters().checkpoint;
  EXPECT_EQ(c.sectors_written, 8u + 4u);
  EXPECT_EQ(c.sectors_read, 8u + 4u);
}

TEST_F(RtUnitCheckpointTest, SmallerEntriesTakeFewerSectors) {
  for (const auto& [bytes, sectors] : {std::pair(16u, 4u), std::pair(8u, 2u)}) {
    SCOPED_TRACE(bytes);
    BenchOptions options = with_sector_buffers();
    options.rt.checkpoint.entry_bytes = bytes;
    const auto group = write_then_replay(8);
    RtBench bench(small_header("tri20", kCapacity), options);
    bench.run(group);
    const auto c = bench.counters().checkpoint;
    EXPECT_EQ(c.sectors_written, sectors);
    EXPECT_EQ(c.sectors_read, sectors);
    EXPECT_EQ(c.straddling_written + c.straddling_read, 0u);
  }
}

TEST_F(RtUnitCheckpointTest, BinsAreReadInTheirOrderAndWhatIsNotReadStays) {
  // Round 0 writes children 0 to 5 to bins 2, 0, 1, 1, 3, 1, of which 3 is the far one. Round 1 reads bin 0 and, of bin
  // 1, one entry, which it forwards to bin 3. Round 2 begins with the rest of bin 1, then comes the far bin.
  traces::RayGroup group;
  group.nodes = {node_definition(1, 10, std::vector<NodeKind>(6, NodeKind::triangle))};
  group.rays.resize(1);
  add_round(group.rays[0], {internal_event(0, 0, 0b111111)});
  add_round(group.rays[0], {take_event(11), leaf_event(11, LeafOutcome::miss), forward_event(12, 1)}, true);
  std::vector<Event> rest;
  for (const std::uint32_t leaf : {13u, 15u, 14u, 12u, 10u}) {
    rest.push_back(take_event(leaf));
    rest.push_back(leaf_event(leaf, LeafOutcome::miss));
  }
  add_round(group.rays[0], rest, true);
  group.rays[0].bins = {2, 0, 1, 1, 3, 1, 3};
  group.rays[0].rounds[1].bins = {0, 3};
  group.rays[0].rounds[2].bins = {1, 1};
  auto header = small_header("tri20", kCapacity);
  header.checkpoint_bins = 3;
  for (const unsigned open : {1u, 8u}) {
    SCOPED_TRACE(open);
    BenchOptions options = with_sector_buffers();
    options.rt.checkpoint.entry_bytes = 8;
    options.rt.checkpoint.open_sectors = open;
    RtBench bench(header, options);
    bench.run(group);
    const std::uint64_t base = bench.map().checkpoint_bin(0, 0);
    const std::uint64_t stride = bench.map().checkpoint_bin(0, 1) - base;
    std::string log;
    for (const auto& r : bench.requests[1]) {
      const std::uint64_t at = r.request.address - base;
      EXPECT_EQ(at % stride, 0u) << "all entries of a bin lie in one sector";
      log += (r.request.write ? "W" : "R") + std::to_string(at / stride) + " ";
    }
    // With one open sector each entry for another bin closes it; with eight they are closed at the end, the one used
    // longest ago first.
    EXPECT_EQ(log, open == 1 ? "W2 W0 W1 W3 R0 W1 R1 W3 R1 R3 R2 " : "W2 W0 W3 W1 R0 R1 W3 R1 R3 R2 ");
    const auto c = bench.counters().checkpoint;
    EXPECT_EQ(c.entries_written, 7u);
    EXPECT_EQ(c.entries_read, 7u);
    EXPECT_EQ(c.max_entries, 6u);
  }
}

TEST_F(RtUnitCheckpointTest, BinsNeedEntriesThatEndWithTheirSector) {
  auto header = small_header("tri20", kCapacity);
  header.checkpoint_bins = 4;
  BenchOptions options;
  EXPECT_THROW(RtBench(header, options), Error) << "20 B";
  options.rt.checkpoint.entry_bytes = 8;
  EXPECT_NO_THROW(RtBench(header, options));
}

// Entries that nobody is charged for: no request for them, and an entry is there in the cycle in which it is read.
TEST_F(RtUnitCheckpointTest, UnchargedEntriesAreNoTrafficAndNobodyWaitsForThem) {
  traces::RayGroup group;  // node 0's six children are checkpointed in round 0; round 1 forwards them all
  group.nodes = {node_definition(1, 10, std::vector<NodeKind>(6, NodeKind::internal))};
  group.rays.resize(4);
  std::vector<Event> forwards;
  for (unsigned i = 0; i < 6; ++i) forwards.push_back(forward_event(10 + i, 1));
  for (traces::Ray& ray : group.rays) {
    add_round(ray, {internal_event(0, 0, 0b111111)});
    add_round(ray, forwards, true);
  }
  BenchOptions options;
  options.rt.checkpoint.traffic = modules::TrafficCharging::uncharged;
  options.rt.checkpoint.write_combine = true;  // an open sector that is never written
  RtBench bench(small_header("tri20", kCapacity), options);
  bench.run(group, 5);
  EXPECT_THAT(bench.requests[1], testing::IsEmpty());
  const modules::CheckpointCounters counters = bench.counters().checkpoint;
  EXPECT_EQ(counters.entries_written, 4u * 12);
  EXPECT_EQ(counters.entries_read, 4u * 6);
  EXPECT_EQ(counters.max_entries, 6u);
}

TEST_F(RtUnitCheckpointTest, LifoReadsFromTheEnd) {
  auto header = small_header("tri20", kCapacity);
  header.checkpoint_order = traces::CheckpointOrder::lifo;
  const auto group = write_then_replay(8);
  RtBench bench(header, with_sector_buffers());
  bench.run(group);
  const std::uint64_t base = bench.map().checkpoint_entry(0, 0, 0);
  EXPECT_THAT(addresses(bench, false), ::testing::ElementsAre(base + 128, base + 96, base + 64, base + 32, base));
}

TEST_F(RtUnitCheckpointTest, BuffersPingPongByRoundParity) {
  // Round 0 writes 2, round 1 forwards both, round 2 takes one and forwards one, round 3 takes it.
  traces::RayGroup group;
  group.nodes = {node_definition(1, 10, std::vector<NodeKind>(2, NodeKind::triangle))};
  group.rays.resize(1);
  add_round(group.rays[0], {internal_event(0, 0, 0b11)});
  add_round(group.rays[0], {forward_event(10, 1), forward_event(11, 1)}, true);
  add_round(group.rays[0], {take_event(10), leaf_event(10, LeafOutcome::miss), forward_event(11, 1)}, true);
  add_round(group.rays[0], {take_event(11), leaf_event(11, LeafOutcome::beyond, 1)}, true);
  RtBench bench(small_header("tri20", kCapacity), with_sector_buffers());
  bench.run(group);
  ASSERT_EQ(bench.dones.size(), 4u);
  const std::uint64_t a = bench.map().checkpoint_entry(0, 0, 0), b = bench.map().checkpoint_entry(0, 1, 0);
  std::vector<std::string> log;
  for (const auto& r : bench.requests[1]) {
    const std::uint64_t at = r.request.address;
    log.push_back(std::string(r.request.write ? "W" : "R") + (at >= b ? "b" : "a") +
                  std::to_string(at - (at >= b ? b : a)));
  }
  EXPECT_THAT(log,
              ::testing::ElementsAre("Wa0", "Wa32", "Ra0", "Ra32", "Wb0", "Wb32", "Rb0", "Rb32", "Wa0", "Ra0", "Wb0"));
  EXPECT_EQ(bench.counters().checkpoint.entries_written, 6u);
  EXPECT_EQ(bench.counters().checkpoint.entries_read, 5u);
}

TEST_F(RtUnitCheckpointTest, WritesCostNoTimeUntilTheUnitIsFull) {
  // Six entries of one lane in the cycle of the box result: four are taken in that cycle, two and the open sector in
  // the next; the last event leaves the sector open, so the warp retires one cycle after the result.
  traces::RayGroup group;
  group.nodes = {node_definition(1, 10, std::vector<NodeKind>(6, NodeKind::internal))};
  group.rays.resize(1);
  add_round(group.rays[0], {internal_event(0, 0, 0b111111)});
  for (const unsigned lanes : {1u, 2u, 4u, 7u, 8u}) {
    SCOPED_TRACE(lanes);
    BenchOptions options = with_sector_buffers();
    options.rt.checkpoint.lanes = lanes;
    RtBench bench(small_header("tri20", kCapacity), options);
    bench.run(group);
    // Seven items: six entries and the open sector (120 B end inside sector 3).
    EXPECT_EQ(bench.dones[0].cycle, kFirstVisit + kBoxTest + (7 + lanes - 1) / lanes - 1);
    // Sectors leave from the cycle after their completion, one per cycle.
    ASSERT_EQ(bench.requests[1].size(), 4u);
    if (lanes >= 7) {
      for (unsigned i = 0; i < 4; ++i) EXPECT_EQ(bench.requests[1][i].cycle, kFirstVisit + kBoxTest + 1 + i);
    }
  }
}

TEST_F(RtUnitCheckpointTest, AFullWriteQueueBlocksTheLane) {
  traces::RayGroup group;
  group.nodes = {node_definition(1, 10, std::vector<NodeKind>(6, NodeKind::internal))};
  group.rays.resize(1);
  add_round(group.rays[0], {internal_event(0, 0, 0b111111)});
  BenchOptions options = with_sector_buffers();
  options.rt.checkpoint.lanes = 32;
  options.rt.checkpoint.write_queue = 2;
  RtBench bench(small_header("tri20", kCapacity), options);
  bench.run(group);
  // Entry 0 completes no sector, 1 and 3 complete sectors 0 and 1; entry 4 finds the queue full. One sector leaves a
  // cycle: entry 4 completes sector 2 one cycle later; entry 5 completes none but needs room, as does the open
  // sector 3.
  EXPECT_EQ(bench.dones[0].cycle, kFirstVisit + kBoxTest + 2);
  EXPECT_EQ(bench.counters().checkpoint.blocked_cycles, 2u);
}

TEST_F(RtUnitCheckpointTest, ReplayReadsThenFetchesTheNodeOnly) {
  // One take of an internal node; the entry's sector is read in the cycle after the scheduling, its data come the
  // memory latency later and the node is scheduled in that cycle.
  traces::RayGroup group;
  group.nodes = {node_definition(1, 10, {NodeKind::internal})};
  group.rays.resize(1);
  add_round(group.rays[0], {internal_event(0, 0, 1)});
  add_round(group.rays[0], {take_event(10), internal_event(0, 0)}, true);
  RtBench bench(small_header("tri20", kCapacity), with_sector_buffers());
  bench.run(group);
  ASSERT_EQ(bench.dones.size(), 2u);
  // Round 1: done seen by the SIMT core one cycle after retirement, call sent, visible, accepted; scheduled the cycle
  // after.
  const Cycle scheduled = bench.dones[0].cycle + 1 + 1 + 1;
  EXPECT_EQ(bench.dones[1].cycle, scheduled + 1 + 20 + kBoxTest);
  EXPECT_EQ(bench.counters().memory.node_visits(), 2u);
}

TEST_F(RtUnitCheckpointTest, AReadWaitsForAWriteOfItsSector) {
  // 32 lanes write one entry each and finish; 32 open sectors take 32 cycles to leave. Their next round asks at once.
  traces::RayGroup group;
  group.nodes = {node_definition(1, 10, std::vector<NodeKind>(6, NodeKind::internal))};
  group.rays.resize(32);
  for (auto& ray : group.rays) {
    add_round(ray, {internal_event(0, 0, 1)});
    add_round(ray, {forward_event(10, 0)}, true);
  }
  BenchOptions options;
  options.rt.checkpoint.lanes = 64;
  options.rt.checkpoint.write_queue = 64;
  options.rt.checkpoint.write_combine = options.rt.checkpoint.read_buffer = true;
  options.rt.ray_box.count = 32;
  RtBench bench(small_header("tri20", kCapacity), options);
  bench.run(group);
  std::map<std::uint64_t, Cycle> written;
  for (const auto& r : bench.requests[1]) {
    if (r.request.write) {
      written[r.request.address] = r.cycle;
    } else {
      ASSERT_TRUE(written.contains(r.request.address)) << "read before the write was sent";
    }
  }
  EXPECT_EQ(written.size(), 32u);
}

TEST_F(RtUnitCheckpointTest, AnEntryBeyondTheCapacityIsRefused) {
  traces::RayGroup group;
  group.nodes = {node_definition(1, 10, std::vector<NodeKind>(6, NodeKind::internal))};
  group.rays.resize(1);
  add_round(group.rays[0], {internal_event(0, 0, 0b111111)});
  RtBench bench(small_header("tri20", 5), {});
  bench.launch(group, 0);
  EXPECT_ANY_THROW(bench.run_expecting_error());
}

}  // namespace
}  // namespace grtx::sim
