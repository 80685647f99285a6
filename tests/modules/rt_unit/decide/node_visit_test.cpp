// SPDX-License-Identifier: Apache-2.0
// Which node an event visits, and which sectors that visit reads, in order.
#include "grtx/modules/rt_unit/decide/node_visit.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace grtx::modules {
namespace {

using traces::Event;
using traces::EventKind;
using traces::NodeKind;

constexpr std::uint64_t kBlas = 4096;

NodeTraffic traffic(bool two_level, NodeTrafficConfig config = {}) {
  traces::Header h;
  h.accel = two_level ? traces::AccelKind::tlas_tri20 : traces::AccelKind::tri20;
  h.two_level = two_level;
  h.blas_base = kBlas;
  return {h, config};
}

std::vector<std::pair<std::uint64_t, Region>> sectors_of(const NodeSectors& sectors) {
  std::vector<std::pair<std::uint64_t, Region>> all;
  for (unsigned i = 0; i < sectors.count(); ++i) all.emplace_back(sectors.at(i).address, sectors.at(i).region);
  return all;
}

TEST(NodeVisit, FindsInternalNodesByTheirDefinition) {
  traces::RayGroup group;
  group.nodes.resize(2);
  group.nodes[1].address = 9;
  const auto visit = node_visit({1, 0, 0, Event::pack(EventKind::visit_internal)}, group, traffic(false));
  ASSERT_TRUE(visit.has_value());
  EXPECT_EQ(visit->address, 9 * traces::kNodeUnit);
  EXPECT_EQ(visit->kind, NodeKind::internal);
  const Event undefined{2, 0, 0, Event::pack(EventKind::visit_internal)};
  EXPECT_FALSE(node_visit(undefined, group, traffic(false)).has_value());
  EXPECT_STREQ(rule_of_missing_node(undefined), "visits an internal node that the group does not define");
}

TEST(NodeVisit, InstancesReadTheHeaderOnlyWhenTheyEnterTheBlas) {
  const traces::RayGroup group;
  const Event enters{3, 0, 0, Event::pack(EventKind::visit_instance)};
  const Event replayed{3, 1, 0, Event::pack(EventKind::visit_instance)};
  EXPECT_TRUE(node_visit(enters, group, traffic(true))->header);
  EXPECT_FALSE(node_visit(replayed, group, traffic(true))->header);
  EXPECT_FALSE(node_visit(enters, group, traffic(true, {128, false, false}))->header);
  EXPECT_FALSE(node_visit(enters, group, traffic(false)).has_value());
  EXPECT_STREQ(rule_of_missing_node(enters), "visits an instance leaf of a monolithic structure");
}

TEST(NodeVisit, ALeafOfTheSceneTlasReadsTheHeaderOfItsObject) {
  traces::Header h;
  h.accel = traces::AccelKind::tlas_tri20;
  h.two_level = true;
  h.blas_base = kBlas;
  h.object_roots = {1024 + 64, 2048 + 64};
  h.scene_leaves = {{192, 1}, {320, 0}};
  const NodeTraffic three(h, {64, true, false});
  const auto reads = [&](std::uint32_t units) {
    const Event enters{units, 0, 0, Event::pack(EventKind::visit_instance)};
    return sectors_of(NodeSectors(*node_visit(enters, {}, three), three));
  };
  using Reads = std::vector<std::pair<std::uint64_t, Region>>;
  const auto with = [](std::uint64_t leaf, std::uint64_t header, Region region) {
    return Reads{{leaf, Region::instance}, {leaf + 32, Region::instance}, {header, region}, {header + 32, region}};
  };
  EXPECT_EQ(reads(3), with(192, 2048, Region::tlas));
  EXPECT_EQ(reads(5), with(320, 1024, Region::tlas));
  EXPECT_EQ(reads(20), with(1280, kBlas, Region::blas));  // a Gaussian's
}

TEST(NodeVisit, ASecondReadIsTheLeafBehindItsDescriptorOrTheHeaderBehindItsInstance) {
  NodeTrafficConfig config{64, true, true};
  EXPECT_EQ(wait_of({NodeKind::triangle, 640, false}, traffic(true, config)), 0u);
  config.descriptor_wait = 4;
  config.header_wait = 8;
  const NodeTraffic reads = traffic(true, config);
  const NodeVisit leaf{NodeKind::triangle, kBlas + 640, false}, instance{NodeKind::instance, 640, true};
  EXPECT_EQ(wait_of(leaf, reads), 4u);
  EXPECT_EQ(wait_of(instance, reads), 8u);
  EXPECT_EQ(wait_of({NodeKind::instance, 640, false}, reads), 0u);
  EXPECT_EQ(wait_of({NodeKind::internal, 640, false}, reads), 0u);
  using Reads = std::vector<std::pair<std::uint64_t, Region>>;
  EXPECT_EQ(sectors_of({leaf, reads, NodePart::first}), (Reads{{kBlas + 640, Region::blas}}));
  EXPECT_EQ(sectors_of({leaf, reads, NodePart::second}),
            (Reads{{kBlas + 640, Region::blas}, {kBlas + 672, Region::blas}}));
  EXPECT_EQ(sectors_of({instance, reads, NodePart::first}), (Reads{{640, Region::instance}, {672, Region::instance}}));
  EXPECT_EQ(sectors_of({instance, reads, NodePart::second}),
            (Reads{{kBlas, Region::blas}, {kBlas + 32, Region::blas}}));
  EXPECT_EQ(NodeSectors(instance, reads, NodePart::second).region(), Region::blas);
  EXPECT_EQ(NodeSectors(instance, reads, NodePart::second).address(), kBlas);
}

TEST(NodeVisit, OnlyVisitsVisit) {
  for (const EventKind kind : {EventKind::cull, EventKind::replay_take, EventKind::replay_forward}) {
    EXPECT_FALSE(node_visit({0, 0, 0, Event::pack(kind)}, {}, traffic(true)).has_value());
  }
}

TEST(NodeSectors, AnInstanceLeafIsFollowedByTheHeader) {
  const NodeTraffic t = traffic(true);
  const NodeSectors sectors({NodeKind::instance, 1024, true}, t);
  EXPECT_EQ(sectors_of(sectors), (std::vector<std::pair<std::uint64_t, Region>>{{1024, Region::instance},
                                                                                {1056, Region::instance},
                                                                                {1088, Region::instance},
                                                                                {1120, Region::instance},
                                                                                {kBlas, Region::blas},
                                                                                {kBlas + 32, Region::blas}}));
}

TEST(NodeSectors, ALeafIsLedByItsDescriptor) {
  const NodeTraffic t = traffic(false, {128, true, true});
  const NodeSectors leaf({NodeKind::triangle, 640, false}, t);
  EXPECT_EQ(sectors_of(leaf), (std::vector<std::pair<std::uint64_t, Region>>{
                                  {640, Region::leaf}, {640, Region::leaf}, {672, Region::leaf}}));
  EXPECT_EQ(NodeSectors({NodeKind::internal, 640, false}, t).count(), 2u) << "internal nodes have no descriptor";
}

// Layout compact: nodes of 80 B begin at a sector or in the middle of one, and take three either way; of an instance
// leaf the first unit is read, and it names the root, so that no header is.
TEST(NodeSectors, CompactNodesTakeThreeSectorsWhereverTheyBegin) {
  traces::Header h;
  h.accel = traces::AccelKind::tlas_tri20;
  h.layout = traces::NodeLayout::compact;
  h.bvh_width = 8;
  h.two_level = true;
  h.blas_base = 80 * 50;
  const NodeTraffic t(h, {});
  EXPECT_EQ(t.address(3), 240u);
  EXPECT_EQ(t.leaf_tests(), 4u);
  EXPECT_EQ(t.stored_units(NodeKind::instance), 2u);
  const Event enters{3, 0, 0, Event::pack(EventKind::visit_instance)};
  const auto visit = node_visit(enters, {}, t);
  ASSERT_TRUE(visit.has_value());
  EXPECT_FALSE(visit->header);
  EXPECT_EQ(sectors_of(NodeSectors(*visit, t)),
            (std::vector<std::pair<std::uint64_t, Region>>{
                {224, Region::instance}, {256, Region::instance}, {288, Region::instance}}));
  EXPECT_EQ(
      sectors_of(NodeSectors({NodeKind::internal, 160, false}, t)),
      (std::vector<std::pair<std::uint64_t, Region>>{{160, Region::tlas}, {192, Region::tlas}, {224, Region::tlas}}));
  h.accel = traces::AccelKind::ellipsoid;
  EXPECT_EQ(NodeTraffic(h, {}).leaf_tests(), 1u);
}

// Layout compressed: whatever a node is, it is two sectors, and no header is read.
TEST(NodeSectors, CompressedNodesAreTwoSectors) {
  traces::Header h;
  h.accel = traces::AccelKind::tlas_tri20;
  h.layout = traces::NodeLayout::compressed;
  h.bvh_width = 8;
  h.two_level = true;
  h.blas_base = 64 * 50;
  const NodeTraffic t(h, {});
  EXPECT_EQ(t.leaf_tests(), 1u);
  const Event enters{3, 0, 0, Event::pack(EventKind::visit_instance)};
  const auto visit = node_visit(enters, {}, t);
  ASSERT_TRUE(visit.has_value());
  EXPECT_FALSE(visit->header);
  EXPECT_EQ(sectors_of(NodeSectors(*visit, t)),
            (std::vector<std::pair<std::uint64_t, Region>>{{192, Region::instance}, {224, Region::instance}}));
  for (const NodeKind kind : {NodeKind::internal, NodeKind::instance, NodeKind::procedural, NodeKind::triangle}) {
    EXPECT_EQ(t.stored_units(kind), 1u);
    EXPECT_EQ(t.run(kind, 128).sectors, 2u);
  }
}

}  // namespace
}  // namespace grtx::modules
