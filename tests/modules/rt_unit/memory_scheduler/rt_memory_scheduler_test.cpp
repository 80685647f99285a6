// SPDX-License-Identifier: Apache-2.0
// Memory scheduler: what merges, in which order sectors leave, when a fetch is complete, what counts in which region.
#include "grtx/modules/rt_unit/memory_scheduler/memory_scheduler.h"

#include <gtest/gtest.h>

#include <array>

#include "grtx/base/error.h"
#include "modules/systemc_fixture.h"

namespace grtx::modules {
namespace {

using traces::NodeKind;

class RtMemorySchedulerTest : public SystemCTest {
 protected:
  static traces::Header header() {
    traces::Header h;
    h.accel = traces::AccelKind::tlas_tri20;
    h.two_level = true;
    h.blas_base = 4096;
    return h;
  }
  static void answer(Link<MemoryResponse>& responses, Cycle now, const MemoryRequest& request) {
    MemoryResponse response{.address = request.address, .tag = request.tag};
    responses.push(now, response);
  }
};

constexpr unsigned kPort = MemorySchedulerConfig::kThroughThePort;

/// A memory scheduler among mocks: a warp buffer without warps, links, and somebody who takes the nodes.
struct SchedulerBench final : warp_buffer_if, fetched_node_if {
  SchedulerBench(const MemoryScheduler::Config& config, const traces::Header& header, unsigned entries,
                 std::size_t capacity = 64)
      : table(entries), memory("memory", config, header, entries), requests("requests", 1, capacity) {
    memory.warp_buffer.bind(*this);
    memory.fetched_node.bind(*this);
    memory.request.bind(requests);
    memory.response.bind(responses);
    elaborate();
  }
  WarpTable& warps() override { return table; }
  void fetched(Cycle, unsigned entry, LaneMask lanes, traces::NodeKind) override {
    completed.push_back(lanes << (32 * entry));
  }
  WarpTable table;
  MemoryScheduler memory;
  Link<MemoryRequest> requests;
  Link<MemoryResponse> responses{"responses", 1, 64};
  std::vector<LaneMask> completed;
};

TEST_F(RtMemorySchedulerTest, EqualAddressesOfOneWarpInOneCycleAreOneFetch) {
  SchedulerBench bench({64, false, false, 1, kPort, 0, false, {}}, header(), 2, 64);
  MemoryScheduler& memory = bench.memory;
  auto& requests = bench.requests;
  memory.begin_warp(5, 0);
  memory.visit(lane_id(0, 3), NodeKind::internal, 128, false);
  memory.visit(lane_id(0, 4), NodeKind::internal, 256, false);
  memory.visit(lane_id(0, 9), NodeKind::internal, 128, false);
  memory.begin_warp(6, 1);  // another warp: its own fetch
  memory.visit(lane_id(1, 0), NodeKind::internal, 128, false);
  EXPECT_EQ(memory.counters().node_visits(), 4u);
  EXPECT_EQ(memory.counters().node_fetches(), 3u);
  Cycle now = 7;
  for (; memory.busy(); ++now) memory.issue(now);
  std::vector<std::uint64_t> addresses;
  while (const auto* r = requests.front(100)) {
    addresses.push_back(r->address);
    answer(bench.responses, 100, *r);
    requests.pop(100);
  }
  EXPECT_EQ(addresses, (std::vector<std::uint64_t>{128, 160, 256, 288, 128, 160}));
  for (Cycle c = 101; c < 107; ++c) memory.respond(c);
  EXPECT_EQ(bench.completed, (std::vector<LaneMask>{0b1000001000, 0b10000, LaneMask{1} << 32}));
  EXPECT_TRUE(memory.idle());
  // Asked in 5, 5 and 6; the second sectors come back in 102, 104 and 106.
  EXPECT_EQ(memory.counters().fetch_latency.sum(), 97u + 99u + 100u);
}

// The netlist does not call the stages of a part that is not awake: sectors would then stay for ever.
TEST_F(RtMemorySchedulerTest, IsAwakeExactlyWhileASectorIsToBeSent) {
  SchedulerBench bench({64, false, false, 1, kPort, 0, false, {}}, header(), 1, 1);
  MemoryScheduler& memory = bench.memory;
  EXPECT_FALSE(memory.awake());
  memory.begin_warp(0, 0);
  memory.visit(0, NodeKind::internal, 128, false);
  EXPECT_TRUE(memory.awake());
  memory.issue(1);
  memory.issue(2);  // no place in the link
  EXPECT_TRUE(memory.awake());
  bench.requests.pop(2);
  memory.issue(3);
  EXPECT_EQ(bench.requests.pushed(), 2u);
  EXPECT_FALSE(memory.awake());
  memory.begin_warp(4, 0);
  memory.visit(0, NodeKind::internal, 256, false);
  memory.restart();
  EXPECT_FALSE(memory.awake()) << "a launch that stood still leaves nothing";
}

TEST_F(RtMemorySchedulerTest, MergingInFlightEndsWithTheLastSector) {
  SchedulerBench bench({64, true, false, 1, kPort, 0, false, {}}, header(), 1, 64);
  MemoryScheduler& memory = bench.memory;
  auto& requests = bench.requests;
  memory.begin_warp(0, 0);
  memory.visit(0, NodeKind::internal, 128, false);
  memory.issue(1);
  memory.issue(2);
  answer(bench.responses, 3, *requests.front(3));
  memory.respond(4);
  EXPECT_TRUE(bench.completed.empty());
  memory.begin_warp(5, 0);
  memory.visit(1, NodeKind::internal, 128, false);  // one sector still missing: joins
  EXPECT_EQ(memory.counters().node_fetches(), 1u);
  answer(bench.responses, 6, *requests.front(6));
  memory.respond(7);
  EXPECT_EQ(bench.completed, (std::vector<LaneMask>{0b11}));
  memory.begin_warp(8, 0);
  memory.visit(2, NodeKind::internal, 128, false);
  EXPECT_EQ(memory.counters().node_fetches(), 2u);
}

TEST_F(RtMemorySchedulerTest, InstancesWithAndWithoutTheHeaderAreDifferentFetches) {
  SchedulerBench bench({64, false, false, 1, kPort, 0, false, {128, true, false}}, header(), 1);
  MemoryScheduler& memory = bench.memory;
  memory.begin_warp(0, 0);
  memory.visit(0, NodeKind::instance, 1024, true);
  memory.visit(1, NodeKind::instance, 1024, false);
  memory.visit(2, NodeKind::instance, 1024, true);
  EXPECT_EQ(memory.counters().node_fetches(), 2u);
}

TEST_F(RtMemorySchedulerTest, RegionsFollowKindAndAddress) {
  const NodeTraffic two_level(header(), {});
  EXPECT_EQ(two_level.region(NodeKind::internal, 64), Region::tlas);
  EXPECT_EQ(two_level.region(NodeKind::instance, 64), Region::instance);
  EXPECT_EQ(two_level.region(NodeKind::internal, 4096), Region::blas);
  EXPECT_EQ(two_level.region(NodeKind::triangle, 8192), Region::blas);
  traces::Header monolithic;
  const NodeTraffic one_level(monolithic, {});
  EXPECT_EQ(one_level.region(NodeKind::internal, 1 << 20), Region::tlas);
  EXPECT_EQ(one_level.region(NodeKind::triangle, 1 << 20), Region::leaf);
  monolithic.bvh_width = 8;
  EXPECT_EQ(NodeTraffic(monolithic, {}).run(NodeKind::internal, 128).sectors, 4u);
}

TEST_F(RtMemorySchedulerTest, AFullLinkHoldsTheSectorBack) {
  SchedulerBench bench({64, false, false, 1, kPort, 0, false, {}}, header(), 1, 1);
  MemoryScheduler& memory = bench.memory;
  auto& requests = bench.requests;
  memory.begin_warp(0, 0);
  memory.visit(0, NodeKind::internal, 128, false);
  const auto sends = [&](Cycle now) {
    const std::uint64_t before = memory.outstanding();
    memory.issue(now);
    return memory.outstanding() != before;
  };
  EXPECT_TRUE(sends(1));
  EXPECT_FALSE(sends(2));
  requests.pop(2);
  EXPECT_FALSE(sends(2));  // the slot is known to be free from the next cycle on
  EXPECT_TRUE(sends(3));
}

// With four warps of a small room an SM, 17 % fewer sectors left the L1 than in Vulkan-Sim, on an object 30 % more.
TEST_F(RtMemorySchedulerTest, SectorsOfTheOldestWarpDoNotWaitForFetchesThatYoungerOnesOpenedFirst) {
  const auto addresses_of = [](bool oldest_warp_first, bool begun) {
    fresh_context();
    SchedulerBench bench({64, false, false, 1, kPort, 0, oldest_warp_first, {}}, header(), 2);
    traces::RayGroup group;
    group.rays.resize(2);
    for (traces::Ray& ray : group.rays) ray.rounds.resize(1);
    for (const std::uint16_t slot : std::array<std::uint16_t, 2>{0, 1})
      bench.table.accept(1, TraceCall{&group, 0, slot, 0b11});
    MemoryScheduler& memory = bench.memory;
    memory.begin_warp(5, 1);
    memory.visit(lane_id(1, 0), NodeKind::internal, 128, false);
    memory.visit(lane_id(1, 1), NodeKind::internal, 256, false);
    Cycle now = 6;
    if (begun) memory.issue(now++);
    memory.begin_warp(now, 0);
    memory.visit(lane_id(0, 0), NodeKind::internal, 512, false);
    memory.visit(lane_id(0, 1), NodeKind::internal, 1024, false);
    for (; memory.busy(); ++now) memory.issue(now);
    std::vector<std::uint64_t> addresses;
    for (; const auto* r = bench.requests.front(100); bench.requests.pop(100)) addresses.push_back(r->address);
    return addresses;
  };
  using Addresses = std::vector<std::uint64_t>;
  EXPECT_EQ(addresses_of(false, false), (Addresses{128, 160, 256, 288, 512, 544, 1024, 1056}));
  EXPECT_EQ(addresses_of(true, false), (Addresses{512, 544, 1024, 1056, 128, 160, 256, 288}));
  EXPECT_EQ(addresses_of(true, true), (Addresses{128, 160, 512, 544, 1024, 1056, 256, 288}));
}

TEST_F(RtMemorySchedulerTest, TheQueueHoldsAtLeastAWarp) {
  EXPECT_THROW(MemoryScheduler("a", {31, false, false, 1, kPort, 0, false, {}}, header(), 1), Error);
  EXPECT_THROW(MemoryScheduler("b", {32, false, false, 1, kPort, 0, false, {96, true, false}}, header(), 1), Error);
}

}  // namespace
}  // namespace grtx::modules
