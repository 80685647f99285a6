// SPDX-License-Identifier: Apache-2.0
// The work of a group as windows mode counts it, by hand, and the sectors that it says are read.
#include "grtx/rtl_tlm/estimate/windows/group_work.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "rtl_tlm/rt_unit/rt_bench.h"
#include "rtl_tlm/tiny_trace.h"

namespace grtx::sim {
namespace {

using test::add_round;
using test::instance_event;
using test::internal_event;
using test::leaf_event;
using traces::LeafOutcome;

/// One lane that visits these leaves in one round; none is hit.
traces::RayGroup leaves(const std::vector<std::uint32_t>& nodes) {
  traces::RayGroup group;
  std::vector<traces::Event> events;
  for (const std::uint32_t node : nodes) events.push_back(leaf_event(node, LeafOutcome::miss));
  group.rays.resize(1);
  add_round(group.rays[0], events);
  return group;
}

GroupWork counted(const traces::Header& header, const traces::RayGroup& group,
                  std::vector<std::uint64_t>* read = nullptr, const modules::NodeTrafficConfig& traffic = {}) {
  const modules::MemoryMap map(header, {});
  WorkCounter counter(header, traffic);
  counter.count(leaves({1, 2, 3}), map, {});  // each group is counted by itself
  return counter.count(
      group, map, read == nullptr ? WorkCounter::Read() : [read](std::uint64_t a) { read->push_back(a); });
}

TEST(GroupWork, CountsTheVisitsOfEveryLaneAndEachSectorOnce) {
  const test::TinyTrace tiny{1, 2};
  const traces::RayGroup group = test::tiny_group(tiny, 0);
  const traces::Header header = test::tiny_header(tiny);
  std::vector<std::uint64_t> read;
  const GroupWork work = counted(header, group, &read);
  EXPECT_DOUBLE_EQ(work.sectors, 2 * (3 * 2));  // two lanes: root and two leaves, two sectors each
  EXPECT_DOUBLE_EQ(work.distinct, static_cast<double>(read.size()));
  std::ranges::sort(read);
  EXPECT_TRUE(std::ranges::adjacent_find(read) == read.end());
  const modules::MemoryMap map(header, {});
  std::vector<std::uint64_t> needed;
  for (const traces::Ray& ray : group.rays) {
    needed.push_back(map.pixel(ray.pixel));
    for (const traces::Processed& p : ray.processed) {
      needed.push_back(map.gaussian_record(p.gaussian));
      needed.push_back(map.sh_record(p.gaussian));
    }
  }
  for (const traces::NodeDefinition& node : group.nodes) needed.push_back(node.address * header.node_sizes().unit());
  ASSERT_GT(needed.size(), 4U);
  for (const std::uint64_t address : needed) {
    EXPECT_TRUE(std::ranges::binary_search(read, address / 32 * 32)) << address;
  }
}

TEST(GroupWork, RoundsFollowEachOtherAndLanesDoNot) {
  traces::RayGroup group;
  group.rays.resize(2);
  const auto round = [&](std::size_t lane, std::uint32_t first, unsigned count) {
    std::vector<traces::Event> events;
    for (unsigned i = 0; i < count; ++i) events.push_back(leaf_event(first + i, LeafOutcome::miss));
    add_round(group.rays[lane], events);
  };
  round(0, 100, 5);
  round(0, 200, 1);
  round(1, 300, 2);
  round(1, 400, 4);
  EXPECT_DOUBLE_EQ(counted({}, group).steps, 5 + 4);
}

TEST(GroupWork, AnInstanceIsFourSectorsAndTheHeaderBelowIt) {
  traces::Header header;
  header.two_level = true;
  traces::RayGroup group;
  group.rays.resize(1);
  add_round(group.rays[0], {instance_event(7), leaf_event(9, LeafOutcome::miss)});
  EXPECT_DOUBLE_EQ(counted(header, group).sectors, 4 + 2 + 2);
  EXPECT_DOUBLE_EQ(counted(header, group, nullptr, {.blas_header_read = false}).sectors, 4 + 2);
}

}  // namespace
}  // namespace grtx::sim
