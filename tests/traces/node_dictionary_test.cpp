// SPDX-License-Identifier: Apache-2.0
// How a group's nodes are stored: by their place in the tree where children lie depth first, by address elsewhere.
#include <gtest/gtest.h>

#include <random>

#include "grtx/traces/codec/columns.h"
#include "grtx/traces/codec/group_codec.h"
#include "grtx/traces/codec/node_shape.h"
#include "traces/random_group.h"

namespace grtx::traces {
namespace {

constexpr auto kI = NodeKind::internal;
constexpr auto kT = NodeKind::triangle;

NodeDefinition node(std::uint32_t address, std::uint32_t child_base, std::vector<NodeKind> kinds) {
  NodeDefinition definition{
      .address = address, .child_base = child_base, .child_count = static_cast<std::uint8_t>(kinds.size())};
  std::copy(kinds.begin(), kinds.end(), definition.child_kinds.begin());
  return definition;
}

Event visit(std::uint32_t index, unsigned pushed) {
  Event event;
  event.node = index;
  event.detail = static_cast<std::uint8_t>(pushed);
  event.kind_shifts = Event::pack(EventKind::visit_internal);
  return event;
}

/// A root with two internal children whose leaves lie where told; one ray visits all three nodes and hits no leaf.
RayGroup two_children(std::uint32_t first_base, std::uint32_t second_base) {
  RayGroup group;
  group.nodes = {node(1, 2, {kI, kT, kI}), node(2, first_base, {kT, kT}), node(4, second_base, {kT, kT, kT})};
  Ray ray;
  ray.events = {visit(0, 0b101), visit(2, 0), visit(1, 0)};
  Round round;
  round.event_count = 3;
  ray.rounds = {round};
  group.rays = {ray};
  return group;
}

Header small_header() {
  Header header = testing::random_trace({}).header;
  header.two_level = false;
  header.root = kNodeUnit;
  header.node_image_bytes = 100 * kNodeUnit;
  return header;
}

ColumnSet columns_of(const Header& header, const RayGroup& group) {
  Bytes payload;
  encode_group(header, group, payload);
  RayGroup decoded;
  decode_group(header, payload.data(), payload.size(), group.index, decoded);
  EXPECT_EQ(decoded, group);
  ColumnSet columns;
  unpack_columns(payload.data(), payload.size(), columns);
  return columns;
}

TEST(NodeDictionary, DepthFirstTreesStoreNoAddresses) {
  const ColumnSet columns = columns_of(small_header(), two_children(5, 7));
  EXPECT_EQ(columns[Column::node_address], Bytes{});
  EXPECT_EQ(columns[Column::node_tree], (Bytes{0b101}));    // both internal children are there
  EXPECT_EQ(columns[Column::node_children], (Bytes{2}));    // the root's begin at 2, all others behind the last
  EXPECT_EQ(columns[Column::node_hits], (Bytes{0, 0, 0}));  // the root hits what is in the dictionary
}

TEST(NodeDictionary, GapsAreNodesThatNoRayVisited) {
  RayGroup group = two_children(5, 20);
  group.nodes.erase(group.nodes.begin() + 1);
  group.rays[0].events = {visit(0, 0b100), visit(1, 0)};
  group.rays[0].rounds[0].event_count = 2;
  const ColumnSet columns = columns_of(small_header(), group);
  EXPECT_EQ(columns[Column::node_tree], (Bytes{0b100}));
  EXPECT_EQ(columns[Column::node_children], (Bytes{2, 15}));  // 15 units behind the root's children
}

TEST(NodeDictionary, AGapThatNoNodeExplainsNeedsAddresses) {
  EXPECT_EQ(columns_of(small_header(), two_children(5, 20))[Column::node_address], (Bytes{1, 1, 2}));
}

TEST(NodeDictionary, HitsOfTheFirstVisitStandWithTheNode) {
  RayGroup group = two_children(5, 7);
  group.rays[0].events = {visit(0, 0b111), visit(2, 0b010), Event{}, Event{}, visit(1, 0)};
  group.rays[0].events[2].node = 8;  // leaves: missed
  group.rays[0].events[3].node = 3;
  for (const std::size_t leaf : {2U, 3U}) {
    group.rays[0].events[leaf].kind_shifts = Event::pack(EventKind::visit_leaf);
  }
  group.rays[0].rounds[0].event_count = 5;
  const ColumnSet columns = columns_of(small_header(), group);
  EXPECT_EQ(columns[Column::node_hits], (Bytes{0b010, 0, 0b010}));  // but for children in the dictionary
  EXPECT_EQ(columns[Column::hits], Bytes{});
}

TEST(NodeDictionary, OtherLayoutsStoreAddresses) {
  const ColumnSet columns = columns_of(small_header(), two_children(20, 10));
  EXPECT_EQ(columns[Column::node_address], (Bytes{1, 1, 2}));
  EXPECT_EQ(columns[Column::node_tree], Bytes{});
}

TEST(NodeDictionary, ANodeThatItsParentDoesNotLeadTo) {
  RayGroup group = two_children(5, 7);
  group.nodes.push_back(node(50, 60, {kT}));
  EXPECT_EQ(columns_of(small_header(), group)[Column::node_address], (Bytes{1, 1, 2, 46}));
}

TEST(NodeDictionary, DamagedTreesAreRefused) {
  const Header header = small_header();
  const ColumnSet sound = columns_of(header, two_children(5, 7));
  const auto decode = [&](const ColumnSet& columns) {
    Bytes payload;
    pack_columns(columns, payload);
    RayGroup group;
    decode_group(header, payload.data(), payload.size(), 0, group);
  };
  EXPECT_NO_THROW(decode(sound));
  ColumnSet columns = sound;
  columns[Column::node_tree] = {0b111};  // child 1 is a leaf
  EXPECT_THROW(decode(columns), Malformed);
  columns[Column::node_tree] = {0b001};  // a node of the dictionary is left over
  EXPECT_THROW(decode(columns), Malformed);
  columns = sound;
  columns[Column::node_children] = {100};  // outside the node image
  EXPECT_THROW(decode(columns), Malformed);
  columns = sound;
  columns[Column::node_hits] = {0, 0b1000, 0};  // the node has two children
  EXPECT_THROW(decode(columns), Malformed);
}

TEST(NodeShape, PlacesOfChildren) {
  std::mt19937 random(3);
  const NodeKind kinds[] = {NodeKind::internal, NodeKind::instance, NodeKind::procedural, NodeKind::triangle};
  ShapeTable table;
  for (const unsigned width : {6u, 8u}) {
    table.set_sizes({NodeLayout::vulkan_sim, width});
    for (unsigned i = 0; i < 5000; ++i) {  // many more shapes than the table holds
      NodeDefinition definition{.child_count = static_cast<std::uint8_t>(1 + random() % width)};
      for (unsigned slot = 0; slot < definition.child_count; ++slot) definition.child_kinds[slot] = kinds[random() % 4];
      const NodeShape& shape = table.shape_of(definition);
      ASSERT_EQ(shape.fault, nullptr);
      unsigned offset = 0;
      for (unsigned slot = 0; slot < definition.child_count; ++slot) {
        const NodeKind kind = definition.child_kinds[slot];
        ASSERT_EQ(shape.offsets >> (4 * slot) & 0xF, offset);
        ASSERT_EQ(kSlotAtOffset[shape.wide_mask][offset], slot);
        ASSERT_EQ((shape.internal_mask >> slot & 1) != 0, kind == NodeKind::internal);
        ASSERT_EQ((shape.instance_mask >> slot & 1) != 0, kind == NodeKind::instance);
        offset += static_cast<unsigned>(node_bytes(kind, width) / kNodeUnit);
      }
      ASSERT_EQ(shape.units, offset);
    }
  }
}

TEST(NodeShape, WideLeavesTakeTwoUnitsWhereTheHeaderHasThem) {
  NodeDefinition definition =
      node(1, 2, {kI, NodeKind::wide_procedural, NodeKind::procedural, NodeKind::wide_procedural});
  ShapeTable table;
  table.set_sizes({NodeLayout::quantised, 6, true});
  const NodeShape& shape = table.shape_of(definition);
  ASSERT_EQ(shape.fault, nullptr);
  EXPECT_EQ(shape.offsets & 0xFFFF, 0x5420u);
  EXPECT_EQ(shape.units, 7);
  EXPECT_EQ(shape.wide_leaves, 0b1010);
  const ShapeTable::Stored* const stored = table.stored(shape.code, shape.kinds_code);
  ASSERT_NE(stored, nullptr);
  EXPECT_EQ(stored->kinds, definition.child_kinds);
  EXPECT_EQ(table.stored(shape.code, shape.kinds_code | 1u << 16), nullptr) << "an internal node is not wide";
  EXPECT_EQ(table.stored(shape.code, shape.kinds_code | 1u << 20), nullptr) << "there is no such child";
  EXPECT_EQ(table.stored(shape.code, shape.kinds_code & 0xFFFFu), nullptr) << "the mask is not empty";
  EXPECT_STREQ(make_shape({NodeLayout::quantised, 6}, definition.child_kinds, 4).fault,
               "a child must be of a known kind");
  EXPECT_STREQ(make_shape({NodeLayout::vulkan_sim, 6}, definition.child_kinds, 4).fault,
               "a child must be of a known kind");
}

TEST(NodeShape, FaultsNameTheRule) {
  NodeDefinition definition = node(1, 2, {kT, kT});
  definition.child_kinds[5] = kT;
  EXPECT_STREQ(make_shape({NodeLayout::vulkan_sim, 6}, definition.child_kinds, 2).fault,
               "an unused child slot must be of kind internal");
  EXPECT_STREQ(make_shape({NodeLayout::vulkan_sim, 6}, definition.child_kinds, 7).fault,
               "a node must have 1..bvh_width children");
  definition.child_kinds[0] = static_cast<NodeKind>(2);
  EXPECT_STREQ(make_shape({NodeLayout::vulkan_sim, 6}, definition.child_kinds, 2).fault,
               "a child must be of a known kind");
}

}  // namespace
}  // namespace grtx::traces
