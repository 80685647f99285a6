// SPDX-License-Identifier: Apache-2.0
// The work of a group as windows mode counts it, by hand: sectors, sectors beyond the L2, dependent steps.
#include "grtx/rtl_tlm/estimate/windows/group_work.h"

#include <gtest/gtest.h>

#include "rtl_tlm/rt_unit/rt_bench.h"
#include "rtl_tlm/tiny_trace.h"

namespace grtx::sim {
namespace {

using test::add_round;
using test::instance_event;
using test::internal_event;
using test::leaf_event;
using traces::LeafOutcome;

constexpr double kShader = 0.5;

GpuConfig without_prefetch() {
  GpuConfig config;
  config.rt.sibling_prefetch = false;
  return config;
}

/// One lane that visits these leaves in one round; none is hit.
traces::RayGroup leaves(const std::vector<std::uint32_t>& nodes) {
  traces::RayGroup group;
  std::vector<traces::Event> events;
  for (const std::uint32_t node : nodes) events.push_back(leaf_event(node, LeafOutcome::miss));
  group.rays.resize(1);
  add_round(group.rays[0], events);
  return group;
}

double steps_of(const traces::RayGroup& group, const GpuConfig& config) {
  const traces::Header header;
  return WorkCounter(header, config).count(group).steps;
}

TEST(GroupWork, CountsTheVisitsOfEveryLaneAndTheStepsOfTheLongest) {
  const test::TinyTrace tiny{1, 2};
  const traces::RayGroup group = test::tiny_group(tiny, 0);
  const traces::Header header = test::tiny_header(tiny);
  WorkCounter counter(header, without_prefetch());
  const auto record =  // sectors of a processed entry
      static_cast<double>((header.gaussian_record_bytes + header.sh_record_bytes + 31) / 32);
  for (int turn = 0; turn < 2; ++turn) {  // each group meets empty caches
    const GroupWork work = counter.count(group);
    EXPECT_DOUBLE_EQ(work.sectors, 2 * (3 * 2));                    // two lanes: root and two leaves, two sectors each
    EXPECT_DOUBLE_EQ(work.dram_sectors, 3 * 2 + 2 * (2 * record));  // the first lane misses; each lane blends two hits
    EXPECT_DOUBLE_EQ(work.steps, 1 + 2 * (1 + kShader));  // of the first lane: the other finds all three nodes
  }
}

TEST(GroupWork, ASiblingThatIsPrefetchedIsNear) {
  GpuConfig config;
  config.rt.sibling_prefetch = true;
  EXPECT_FLOAT_EQ(static_cast<float>(steps_of(leaves({10, 11, 12}), config)), 1 + 2 * 0.15F);
  EXPECT_FLOAT_EQ(static_cast<float>(steps_of(leaves({10, 11, 12}), without_prefetch())), 3);
}

TEST(GroupWork, TheShareOfAWarpHoldsFourNodesByLeastRecentUse) {
  GpuConfig config = without_prefetch();
  config.l1.geometry.bytes = 4096;  // 0.7 x 4096 / (8 warps x 64 B): one set of four ways
  const auto steps = [&](const std::vector<std::uint32_t>& nodes) {
    return static_cast<float>(steps_of(leaves(nodes), config));
  };
  EXPECT_FLOAT_EQ(steps({1, 2, 3, 4, 1, 2, 3, 4}), 4 + 4 * 0.15F);
  EXPECT_FLOAT_EQ(steps({1, 2, 3, 4, 5, 1}), 6);                 // 1 went for 5
  EXPECT_FLOAT_EQ(steps({1, 2, 3, 4, 1, 5, 1}), 5 + 2 * 0.15F);  // 2 went: 1 was used since
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
  EXPECT_DOUBLE_EQ(steps_of(group, without_prefetch()), 5 + 4);
}

TEST(GroupWork, AnInstanceIsFourSectorsAndACheckpointWhatItsEntryIs) {
  traces::Header header;
  header.checkpoint = true;
  const auto far = [&](unsigned entry_bytes, bool combined) {
    GpuConfig config = without_prefetch();
    config.rt.checkpoint.entry_bytes = entry_bytes;
    config.rt.checkpoint.write_combine = combined;
    traces::RayGroup group;
    group.rays.resize(1);
    add_round(group.rays[0], {instance_event(7), leaf_event(9, LeafOutcome::miss, 0b11), test::take_event(11)});
    const GroupWork work = WorkCounter(header, config).count(group);
    EXPECT_DOUBLE_EQ(work.sectors, 4 + 2);
    return static_cast<float>(work.dram_sectors);
  };
  EXPECT_FLOAT_EQ(far(16, false), 6 + 2 * 1 + 1);         // two entries written, one read; none straddles two sectors
  EXPECT_FLOAT_EQ(far(20, false), 6 + 2 * 1.5F + 1.5F);   // half of them do
  EXPECT_FLOAT_EQ(far(20, true), 6 + 2 * 0.625F + 1.5F);  // joined before they are written
}

}  // namespace
}  // namespace grtx::sim
