// The private store of the RT unit: the first entries of a ray's checkpoint buffers on chip. One entry a cycle is
// written, `read_ports` are read, each there `latency` cycles later; what lies behind is traffic as before.
#include <gmock/gmock.h>

#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "rtl_tlm/rt_unit/rt_bench.h"

namespace grtx::sim {
namespace {

using namespace test;
using modules::Region;

class RtUnitPrivateStoreTest : public modules::SystemCTest {};

constexpr Cycle kFirst = 2;
constexpr Cycle kBox = 2 + 20 + 1 + 13;
constexpr std::uint64_t kCapacity = 64;

BenchOptions with_store(unsigned entries, unsigned latency = 4, unsigned read_ports = 1) {
  BenchOptions options;
  options.rt.checkpoint.store.entries = entries;
  options.rt.checkpoint.store.latency = latency;
  options.rt.checkpoint.store.read_ports = read_ports;
  return options;
}

/// One node whose six children are checkpointed in round 0; round 1 forwards them all.
traces::RayGroup six_forwarded(unsigned rays = 1) {
  traces::RayGroup group;
  group.nodes = {node_definition(1, 10, std::vector<NodeKind>(6, NodeKind::internal))};
  group.rays.resize(rays);
  std::vector<Event> forwards;
  for (unsigned i = 0; i < 6; ++i) forwards.push_back(forward_event(10 + i, 1));
  for (traces::Ray& ray : group.rays) {
    add_round(ray, {internal_event(0, 0, 0b111111)});
    add_round(ray, forwards, true);
  }
  return group;
}

// Entries that nobody is charged for: no request for them, and an entry is there in the cycle in which it is read.
TEST_F(RtUnitPrivateStoreTest, UnchargedEntriesAreNoTrafficAndNobodyWaitsForThem) {
  BenchOptions options;
  options.rt.checkpoint.traffic = modules::TrafficCharging::uncharged;
  options.rt.checkpoint.write_combine = true;  // an open sector that is never written
  RtBench bench(small_header("tri20", kCapacity), options);
  const auto group = six_forwarded(4);
  bench.run(group, 5);
  EXPECT_THAT(bench.requests[1], testing::IsEmpty());
  const modules::CheckpointCounters counters = bench.counters().checkpoint;
  EXPECT_EQ(counters.entries_written, 4u * 12);
  EXPECT_EQ(counters.entries_read, 4u * 6);
  EXPECT_EQ(counters.max_entries, 6u);
}

TEST_F(RtUnitPrivateStoreTest, OnlyEntriesBehindItsOwnAreTraffic) {
  const auto group = six_forwarded();
  for (const unsigned held : {0u, 1u, 4u, 6u, 100u}) {
    SCOPED_TRACE(held);
    RtBench bench(small_header("tri20", kCapacity), with_store(held));
    bench.run(group, 5);
    const std::uint64_t ray = bench.map().ray_slot(0, 5, 0);
    std::vector<std::uint64_t> expected;  // written in round 0: entry i touches bytes 20 i to 20 i + 19
    for (unsigned i = held; i < 6; ++i) {
      const std::uint64_t first = bench.map().checkpoint_entry(ray, 0, i) / 32, last = (i * 20 + 19) / 32;
      expected.push_back(first * 32);
      if ((i * 20) / 32 != last) expected.push_back(first * 32 + 32);
    }
    std::vector<std::uint64_t> written, read;
    const std::uint64_t second = bench.map().checkpoint_entry(ray, 1, 0);
    for (const auto& r : bench.requests[1]) {
      if (r.request.write && r.request.address < second) written.push_back(r.request.address);
      if (!r.request.write) read.push_back(r.request.address);
    }
    EXPECT_EQ(written, expected);
    EXPECT_EQ(read, expected);
    const auto c = bench.counters().checkpoint;
    EXPECT_EQ(c.entries_written, 12u);
    EXPECT_EQ(c.entries_read, 6u);
    EXPECT_EQ(c.store_written, 2 * std::min(held, 6u));
    EXPECT_EQ(c.store_read, std::min(held, 6u));
    EXPECT_EQ(c.store_returned, c.store_read);
  }
}

TEST_F(RtUnitPrivateStoreTest, OneEntryACycleIsWritten) {
  // Six entries in the cycle of the box result: one of the store's in it and in each of the next, four others a cycle.
  traces::RayGroup group;
  group.nodes = {node_definition(1, 10, std::vector<NodeKind>(6, NodeKind::internal))};
  group.rays.resize(1);
  add_round(group.rays[0], {internal_event(0, 0, 0b111111)});
  struct Case {
    unsigned held;
    Cycle more;  // cycles in which the lane waits
  };
  // With two in the store the second cycle also takes three others; the last goes in the third.
  for (const Case& c : {Case{0, 1}, Case{2, 2}, Case{6, 5}}) {
    SCOPED_TRACE(c.held);
    RtBench bench(small_header("tri20", kCapacity), with_store(c.held));
    bench.run(group);
    EXPECT_EQ(bench.dones[0].cycle, kFirst + kBox + c.more);
  }
}

TEST_F(RtUnitPrivateStoreTest, AReadTakesItsLatencyInPlaceOfTheMemorys) {
  traces::RayGroup group;
  group.nodes = {node_definition(1, 10, {NodeKind::internal})};
  group.rays.resize(1);
  add_round(group.rays[0], {internal_event(0, 0, 1)});
  add_round(group.rays[0], {take_event(10), internal_event(0, 0)}, true);
  for (const unsigned latency : {1u, 4u, 30u}) {
    SCOPED_TRACE(latency);
    RtBench bench(small_header("tri20", kCapacity), with_store(1, latency));
    bench.run(group);
    ASSERT_EQ(bench.dones.size(), 2u);
    const Cycle scheduled = bench.dones[0].cycle + 1 + 1 + 1;
    EXPECT_EQ(bench.dones[1].cycle, scheduled + 1 + latency + kBox);
    EXPECT_TRUE(bench.requests[1].empty());
  }
}

TEST_F(RtUnitPrivateStoreTest, LanesShareItsReadPorts) {
  // 32 lanes of a warp ask in the same cycle; the last of them is served after 32 / ports cycles.
  traces::RayGroup group;
  group.nodes = {node_definition(1, 10, {NodeKind::internal})};
  group.rays.resize(32);
  for (traces::Ray& ray : group.rays) {
    add_round(ray, {internal_event(0, 0, 1)});
    add_round(ray, {forward_event(10, 0)}, true);
  }
  for (const unsigned ports : {1u, 2u, 8u}) {
    SCOPED_TRACE(ports);
    RtBench bench(small_header("tri20", kCapacity), with_store(1, 4, ports));
    bench.run(group);
    ASSERT_EQ(bench.dones.size(), 2u);
    const Cycle scheduled = bench.dones[0].cycle + 1 + 1 + 1;
    EXPECT_EQ(bench.dones[1].cycle, scheduled + 1 + (32 / ports - 1) + 4);
  }
}

TEST_F(RtUnitPrivateStoreTest, LifoReadsTheStoredEntriesLast) {
  auto header = small_header("tri20", kCapacity);
  header.checkpoint_order = traces::CheckpointOrder::lifo;
  const auto group = six_forwarded();
  RtBench bench(header, with_store(4));
  bench.run(group);
  std::vector<std::uint64_t> read;
  for (const auto& r : bench.requests[1]) {
    if (!r.request.write) read.push_back(r.request.address - bench.map().checkpoint_entry(0, 0, 0));
  }
  // Entry 5 at byte 100, entry 4 at 80: of its two sectors the one that the next entry would share comes last.
  EXPECT_THAT(read, ::testing::ElementsAre(96, 96, 64));
  EXPECT_EQ(bench.counters().checkpoint.store_read, 4u);
}

TEST_F(RtUnitPrivateStoreTest, NoOpenSectorIsLeftWhenAllEntriesAreStored) {
  const auto group = six_forwarded();
  for (const unsigned held : {5u, 6u}) {
    SCOPED_TRACE(held);
    BenchOptions options = with_store(held);
    options.rt.checkpoint.write_combine = options.rt.checkpoint.read_buffer = true;
    RtBench bench(small_header("tri20", kCapacity), options);
    bench.run(group);
    // Entry 5 lies in sector 3 alone.
    EXPECT_EQ(bench.counters().checkpoint.sectors_written, held == 5 ? 2u : 0u);
    EXPECT_EQ(bench.counters().checkpoint.sectors_read, held == 5 ? 1u : 0u);
  }
}

TEST_F(RtUnitPrivateStoreTest, IsPricedByItsEntriesWarpsAndPorts) {
  GpuConfig config = load_config(
      "", {"rt.checkpoint.traffic=charged", "rt.private_store.checkpoint_entries=3", "rt.private_store.read_ports=2",
           "rt.checkpoint.entry_bytes=16", "gpu.resident_warps=12", "gpu.rt_units=2"});
  BenchOptions options;
  options.rt = config.sm(0).rt;
  RtBench bench(small_header("tri20", kCapacity), options);
  const auto inventory = bench.rt().inventory();
  const modules::Storage* store = nullptr;
  for (const auto& part : inventory) {
    for (const auto& storage : part.storage) {
      if (storage.name == "private_store") store = &storage;
    }
  }
  ASSERT_NE(store, nullptr);
  EXPECT_EQ(store->bits, 2u * 3 * 16 * 8 * 6 * 32);  // buffers, entries, bits, warps of a unit, lanes
  EXPECT_EQ(store->read_ports, 2u);
  EXPECT_EQ(store->word_bits, 128u);
}

TEST(PrivateStoreConfig, RefusesLanesOfOddBytes) {
  EXPECT_THROW(load_config("", {"simt.private_store.lane_bytes=6"}), Error);
}

}  // namespace
}  // namespace grtx::sim
