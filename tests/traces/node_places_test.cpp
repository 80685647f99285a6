// SPDX-License-Identifier: Apache-2.0
// Groups of a trace must agree on where nodes lie: a simulation merges their fetches by address.
#include "grtx/traces/codec/node_places.h"

#include <gmock/gmock.h>

#include "error_of.h"
#include "grtx/base/error.h"

namespace grtx::traces {
namespace {

using Kinds = std::vector<NodeKind>;

RayGroup group(std::uint32_t index, std::uint32_t address, std::uint32_t child_base, const Kinds& kinds) {
  NodeDefinition node{
      .address = address, .child_base = child_base, .child_count = static_cast<std::uint8_t>(kinds.size())};
  std::copy(kinds.begin(), kinds.end(), node.child_kinds.begin());
  RayGroup result;
  result.index = index;
  result.nodes = {node};
  return result;
}

/// What check() says of these groups, added to one or to a place each.
std::string fault_of(const std::vector<RayGroup>& groups, bool apart) {
  const Header header;
  NodePlaces places(header);
  for (const RayGroup& g : groups) {
    if (!apart) {
      places.add(g);
      continue;
    }
    NodePlaces own(header);
    own.add(g);
    places.add(own);
  }
  return grtx::test::error_of([&] { places.check("t.grtx"); });
}

TEST(NodePlaces, AgreeWhenGroupsVisitPartsOfOneTree) {
  const Kinds two = {NodeKind::internal, NodeKind::triangle};
  for (const bool apart : {false, true}) {
    EXPECT_EQ(
        fault_of({group(0, 1, 10, two), group(1, 1, 10, two), group(2, 10, 12, two), group(3, 11, 14, two)}, apart),
        "");
  }
}

TEST(NodePlaces, RefuseANodeWithOtherChildrenInAnotherGroup) {
  const Kinds leaf = {NodeKind::triangle, NodeKind::triangle}, inner = {NodeKind::internal, NodeKind::triangle};
  for (const bool apart : {false, true}) {
    EXPECT_EQ(fault_of({group(3, 1, 10, leaf), group(7, 1, 10, leaf), group(5, 1, 10, inner)}, apart),
              "t.grtx: group 5 node 1: has other children than in group 3");
    EXPECT_EQ(fault_of({group(5, 1, 10, inner), group(7, 1, 10, leaf), group(3, 1, 10, leaf)}, apart),
              "t.grtx: group 5 node 1: has other children than in group 3");
    EXPECT_EQ(fault_of({group(0, 1, 10, leaf), group(1, 1, 12, leaf)}, apart),
              "t.grtx: group 1 node 1: has other children than in group 0");
  }
}

TEST(NodePlaces, RefuseChildrenThatOverlap) {
  const Kinds two = {NodeKind::triangle, NodeKind::triangle}, wide = {NodeKind::instance};
  EXPECT_EQ(fault_of({group(0, 1, 10, two), group(4, 2, 11, two)}, true),
            "t.grtx: group 4 node 2: its children overlap those of node 1");
  EXPECT_EQ(fault_of({group(0, 1, 10, wide), group(4, 2, 11, two)}, true),
            "t.grtx: group 4 node 2: its children overlap those of node 1");
  EXPECT_EQ(fault_of({group(0, 1, 10, wide), group(4, 2, 12, two)}, true), "");
}

}  // namespace
}  // namespace grtx::traces
