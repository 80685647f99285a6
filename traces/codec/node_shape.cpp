// SPDX-License-Identifier: Apache-2.0
#include "grtx/traces/codec/node_shape.h"

#include <bit>
#include <cstring>

#include "grtx/traces/codec/group_codec.h"

namespace grtx::traces {
namespace {

unsigned stored_kind(NodeKind kind) {
  switch (without_width(kind)) {
    case NodeKind::internal:
      return 0;
    case NodeKind::instance:
      return 1;
    case NodeKind::procedural:
      return 2;
    default:
      return 3;
  }
}

// Usually all leaves of a node have one kind: stores that kind, and a mask of the internal children if there are both.
void set_codes(const std::array<NodeKind, kMaxWidth>& kinds, NodeShape& shape) {
  const unsigned leaves = ((1U << shape.child_count) - 1) & ~unsigned{shape.internal_mask};
  const unsigned leaf = leaves != 0 ? stored_kind(kinds[static_cast<unsigned>(std::countr_zero(leaves))]) : 0;
  unsigned all = 0;
  bool irregular = false;
  for (unsigned slot = 0; slot < shape.child_count; ++slot) {
    const unsigned kind = stored_kind(kinds[slot]);
    all |= kind << (2 * slot);
    irregular |= kind != 0 && kind != leaf;
  }
  unsigned code = shape.child_count;
  if (irregular || shape.wide_leaves != 0) {
    code |= kShapeIrregular | (shape.wide_leaves != 0 ? kShapeWide : 0);
    shape.kinds_code = all | std::uint32_t{shape.wide_leaves} << 16;
  } else {
    code |= leaf << 4;
    if (leaf != 0 && shape.internal_mask != 0) {
      code |= kShapeMixed;
      shape.kinds_code = shape.internal_mask;
    }
  }
  shape.code = static_cast<std::uint8_t>(code);
}

// Moves bit i to bit 2 i.
unsigned spread_bits(unsigned byte) { return scatter_bits(byte, 0x5555); }

}  // namespace

NodeShape make_shape(const NodeSizes& sizes, const std::array<NodeKind, kMaxWidth>& kinds, unsigned child_count) {
  NodeShape shape;
  if (child_count < 1 || child_count > sizes.width()) {
    shape.fault = "a node must have 1..bvh_width children";
    return shape;
  }
  shape.child_count = static_cast<std::uint8_t>(child_count);
  unsigned internal = 0, instance = 0, wide = 0, wide_leaves = 0, offset = 0;
  for (unsigned slot = 0; slot < kMaxWidth; ++slot) {
    const NodeKind kind = kinds[slot];
    const bool known = kind == NodeKind::internal || kind == NodeKind::instance || kind == NodeKind::procedural ||
                       kind == NodeKind::triangle || (sizes.wide_leaves() && is_wide(kind));
    if (!known) {
      shape.fault = "a child must be of a known kind";
      return shape;
    }
    if (slot >= child_count) {
      if (kind != NodeKind::internal) shape.fault = "an unused child slot must be of kind internal";
      continue;
    }
    const unsigned units = sizes.units(kind);
    shape.offsets |= offset << (4 * slot);
    offset += units;
    internal |= (kind == NodeKind::internal ? 1U : 0U) << slot;
    instance |= (without_width(kind) == NodeKind::instance ? 1U : 0U) << slot;
    wide |= (units == 2 ? 1U : 0U) << slot;
    wide_leaves |= (is_wide(kind) ? 1U : 0U) << slot;
  }
  shape.internal_mask = static_cast<std::uint8_t>(internal);
  shape.instance_mask = static_cast<std::uint8_t>(instance);
  shape.wide_mask = static_cast<std::uint8_t>(wide);
  shape.wide_leaves = static_cast<std::uint8_t>(wide_leaves);
  shape.units = static_cast<std::uint8_t>(offset);
  if (shape.fault == nullptr) set_codes(kinds, shape);
  return shape;
}

void ShapeTable::set_sizes(const NodeSizes& sizes) {
  if (sizes_ == sizes) return;
  sizes_ = sizes;
  entries_.assign(std::size_t{1} << kBits, Entry{});
  stored_.assign(std::size_t{1} << kBits, Stored{});
}

const NodeShape& ShapeTable::shape_of(const NodeDefinition& node) {
  std::uint64_t kinds = 0;
  static_assert(sizeof node.child_kinds == sizeof kinds);
  std::memcpy(&kinds, node.child_kinds.data(), sizeof kinds);
  Entry& entry = entries_[slot_of(kinds + node.child_count)];
  if (entry.kinds != kinds || entry.count != node.child_count) {
    entry = {kinds, node.child_count, make_shape(sizes_, node.child_kinds, node.child_count)};
  }
  return entry.shape;
}

bool ShapeTable::store(unsigned code, unsigned kinds_code, Stored& entry) const {
  const unsigned leaf = code >> 4 & 3;
  const unsigned count = code & 0xF;
  const bool mixed = (code & kShapeMixed) != 0;
  const bool irregular = (code & kShapeIrregular) != 0;
  const unsigned wide = irregular ? kinds_code >> 16 : 0;
  const unsigned free = sizes_.wide_leaves() && wide != 0 ? kShapeWide : 0;
  if (count > kMaxWidth || (mixed && leaf == 0) || (irregular && (code & 0x70) != free)) return false;
  unsigned all = leaf * 0x5555;
  if (mixed) all &= ~(spread_bits(kinds_code) * 3);
  if (irregular) all = kinds_code;
  if (wide >> count != 0) return false;
  Kinds kinds{};
  for (unsigned slot = 0; slot < count; ++slot) {
    kinds[slot] = kStoredKinds[all >> (2 * slot) & 3];
    if ((wide >> slot & 1) == 0) continue;
    if (kinds[slot] != NodeKind::instance && kinds[slot] != NodeKind::procedural) return false;
    kinds[slot] = wide_kind(kinds[slot]);
  }
  entry = {code | kinds_code << 8, kinds, make_shape(sizes_, kinds, count)};
  return true;
}

}  // namespace grtx::traces
