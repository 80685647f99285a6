// Memory scheduler: what merges, in which order sectors leave, when a fetch is complete, what counts in which region.
#include "grtx/modules/rt_unit/memory_scheduler.h"

#include <gtest/gtest.h>

#include "grtx/base/error.h"
#include "modules/systemc_fixture.h"

namespace grtx::modules {
namespace {

using traces::NodeKind;

class RtMemorySchedulerTest : public SystemCTest {
 protected:
  static traces::Header header() {
    traces::Header h;
    h.accel = "tlas-tri20";
    h.two_level = true;
    h.blas_base = 4096;
    return h;
  }
  static void answer(Link<MemoryResponse>& responses, Cycle now, const MemoryRequest& request) {
    MemoryResponse response;
    response.tag = request.tag;
    response.address = request.address;
    responses.push(now, response);
  }
};

TEST_F(RtMemorySchedulerTest, EqualAddressesOfOneWarpInOneCycleAreOneFetch) {
  MemoryScheduler memory("memory", {64, false, false, {}}, header(), 2);
  Link<MemoryRequest> requests("requests", 1, 64);
  Link<MemoryResponse> responses("responses", 1, 64);
  memory.begin_warp(5, 0);
  memory.visit(lane_id(0, 3), NodeKind::internal, 128, false);
  memory.visit(lane_id(0, 4), NodeKind::internal, 256, false);
  memory.visit(lane_id(0, 9), NodeKind::internal, 128, false);
  memory.begin_warp(6, 1);  // another warp: its own fetch
  memory.visit(lane_id(1, 0), NodeKind::internal, 128, false);
  EXPECT_EQ(memory.counters().node_visits(), 4u);
  EXPECT_EQ(memory.counters().node_fetches(), 3u);
  Cycle now = 7;
  for (; memory.issue(now, requests); ++now) {
  }
  std::vector<std::uint64_t> addresses;
  std::vector<LaneMask> completed;
  while (const auto* r = requests.front(100)) {
    addresses.push_back(r->address);
    answer(responses, 100, *r);
    requests.pop(100);
  }
  EXPECT_EQ(addresses, (std::vector<std::uint64_t>{128, 160, 256, 288, 128, 160}));
  for (Cycle c = 101; c < 107; ++c) {
    const auto done = memory.respond(c, responses);
    if (done.lanes != 0) completed.push_back(done.lanes << (32 * done.entry));
  }
  EXPECT_EQ(completed, (std::vector<LaneMask>{0b1000001000, 0b10000, LaneMask{1} << 32}));
  EXPECT_TRUE(memory.idle());
  // Asked in 5, 5 and 6; the second sectors come back in 102, 104 and 106.
  EXPECT_EQ(memory.counters().fetch_latency.sum(), 97u + 99u + 100u);
}

TEST_F(RtMemorySchedulerTest, MergingInFlightEndsWithTheLastSector) {
  MemoryScheduler memory("memory", {64, true, false, {}}, header(), 1);
  Link<MemoryRequest> requests("requests", 1, 64);
  Link<MemoryResponse> responses("responses", 1, 64);
  memory.begin_warp(0, 0);
  memory.visit(0, NodeKind::internal, 128, false);
  memory.issue(1, requests);
  memory.issue(2, requests);
  answer(responses, 3, *requests.front(3));
  EXPECT_EQ(memory.respond(4, responses).lanes, 0u);
  memory.begin_warp(5, 0);
  memory.visit(1, NodeKind::internal, 128, false);  // one sector still missing: joins
  EXPECT_EQ(memory.counters().node_fetches(), 1u);
  answer(responses, 6, *requests.front(6));
  EXPECT_EQ(memory.respond(7, responses).lanes, 0b11u);
  memory.begin_warp(8, 0);
  memory.visit(2, NodeKind::internal, 128, false);
  EXPECT_EQ(memory.counters().node_fetches(), 2u);
}

TEST_F(RtMemorySchedulerTest, InstancesWithAndWithoutTheHeaderAreDifferentFetches) {
  MemoryScheduler memory("memory", {64, false, false, {128, true, false}}, header(), 1);
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
  EXPECT_EQ(NodeTraffic(monolithic, {}).sectors(NodeKind::internal), 4u);
}

TEST_F(RtMemorySchedulerTest, AFullLinkHoldsTheSectorBack) {
  MemoryScheduler memory("memory", {64, false, false, {}}, header(), 1);
  Link<MemoryRequest> requests("requests", 1, 1);
  memory.begin_warp(0, 0);
  memory.visit(0, NodeKind::internal, 128, false);
  EXPECT_TRUE(memory.issue(1, requests));
  EXPECT_FALSE(memory.issue(2, requests));
  requests.pop(2);
  EXPECT_FALSE(memory.issue(2, requests));  // the slot is known to be free from the next cycle on
  EXPECT_TRUE(memory.issue(3, requests));
}

TEST_F(RtMemorySchedulerTest, TheQueueHoldsAtLeastAWarp) {
  EXPECT_THROW(MemoryScheduler("a", {31, false, false, {}}, header(), 1), Error);
  EXPECT_THROW(MemoryScheduler("b", {32, false, false, {96, true, false}}, header(), 1), Error);
}

}  // namespace
}  // namespace grtx::modules
