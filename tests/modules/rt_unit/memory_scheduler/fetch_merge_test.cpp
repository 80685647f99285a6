// SPDX-License-Identifier: Apache-2.0
// Which reads of a warp share a fetch.
#include "grtx/modules/rt_unit/memory_scheduler/decide/fetch_merge.h"

#include <gtest/gtest.h>

namespace grtx::modules {
namespace {

using traces::NodeKind;

constexpr std::uint64_t kBlasNode = 4096;

NodeTraffic traffic(const NodeTrafficConfig& config = {}) {
  traces::Header header;
  header.accel = traces::AccelKind::tlas_tri20;
  header.two_level = true;
  header.blas_base = kBlasNode;
  return {header, config};
}

std::uint64_t key(const NodeVisit& visit, NodePart part = NodePart::whole) {
  return FetchMerge::key(visit, part, traffic());
}

TEST(FetchMerges, WhenWarpAndNodeAreEqual) {
  FetchMerge merge(2, true);
  const std::uint64_t node = key({NodeKind::internal, 640});
  merge.begin(lane_id(1, 5), node, NodePart::whole);
  EXPECT_EQ(merge.find(1, node, NodePart::whole), lane_id(1, 5));
  EXPECT_EQ(merge.find(0, node, NodePart::whole), FetchMerge::kNone) << "another warp";
  EXPECT_EQ(merge.find(1, key({NodeKind::internal, 704}), NodePart::whole), FetchMerge::kNone) << "another node";
}

TEST(FetchMerges, NotWhenOneOfTwoVisitsOfAnInstanceLeafReadsAHeader) {
  EXPECT_NE(key({NodeKind::instance, 640, true}), key({NodeKind::instance, 640, false}));
}

TEST(FetchMerges, NotALeafWithItsDescriptor) {
  NodeTrafficConfig config;
  config.leaf_descriptor_read = true;
  config.descriptor_wait = 4;
  const NodeVisit leaf{NodeKind::triangle, kBlasNode + 640};
  EXPECT_NE(FetchMerge::key(leaf, NodePart::first, traffic(config)),
            FetchMerge::key(leaf, NodePart::second, traffic(config)));
}

TEST(FetchMerges, AHeaderFetchedAloneByTheAddressOfTheHeader) {
  NodeTrafficConfig config;
  config.header_wait = 8;
  const auto header_of = [&](std::uint64_t leaf) {
    return FetchMerge::key({NodeKind::instance, leaf, true}, NodePart::second, traffic(config));
  };
  EXPECT_EQ(header_of(640), header_of(768)) << "both instances have the BLAS whose header this is";
}

TEST(FetchMerges, UntilTheDataHaveCome) {
  FetchMerge merge(1, true);
  const std::uint64_t node = key({NodeKind::internal, 640});
  merge.begin(lane_id(0, 3), node, NodePart::whole);
  merge.begin_warp(0);
  EXPECT_EQ(merge.find(0, node, NodePart::whole), lane_id(0, 3)) << "the warp was selected once more";
  merge.end(lane_id(0, 3), node);
  EXPECT_EQ(merge.find(0, node, NodePart::whole), FetchMerge::kNone);
}

TEST(FetchMerges, OnlyWithFetchesOfTheSameSelectionIfNotInFlight) {
  FetchMerge merge(2, false);
  const std::uint64_t node = key({NodeKind::internal, 640});
  merge.begin_warp(0);
  merge.begin(lane_id(0, 3), node, NodePart::whole);
  EXPECT_EQ(merge.find(0, node, NodePart::whole), lane_id(0, 3));
  merge.end(lane_id(0, 3), node);
  EXPECT_EQ(merge.find(0, node, NodePart::whole), lane_id(0, 3)) << "the warp is still the selected one";
  merge.begin_warp(1);
  EXPECT_EQ(merge.find(0, node, NodePart::whole), FetchMerge::kNone);
}

TEST(FetchMerges, NoSecondReadIfNotInFlight) {
  FetchMerge merge(1, false);
  const std::uint64_t header = key({NodeKind::instance, 640, true}, NodePart::second);
  merge.begin_warp(0);
  merge.begin(lane_id(0, 3), header, NodePart::second);
  EXPECT_EQ(merge.find(0, header, NodePart::second), FetchMerge::kNone);
}

}  // namespace
}  // namespace grtx::modules
