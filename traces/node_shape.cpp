#include "traces/node_shape.h"

#include <cstring>

namespace grtx::traces {

NodeShape make_shape(unsigned bvh_width, const std::array<NodeKind, kMaxWidth>& kinds, unsigned child_count) {
  NodeShape shape;
  if (child_count < 1 || child_count > bvh_width) {
    shape.fault = "a node must have 1..bvh_width children";
    return shape;
  }
  shape.child_count = static_cast<std::uint8_t>(child_count);
  unsigned internal = 0, instance = 0, wide = 0, offset = 0;
  for (unsigned slot = 0; slot < kMaxWidth; ++slot) {
    const NodeKind kind = kinds[slot];
    if (kind != NodeKind::internal && kind != NodeKind::instance && kind != NodeKind::procedural &&
        kind != NodeKind::triangle) {
      shape.fault = "a child must be of a known kind";
      return shape;
    }
    if (slot >= child_count) {
      if (kind != NodeKind::internal) shape.fault = "an unused child slot must be of kind internal";
      continue;
    }
    const auto units = static_cast<unsigned>(node_bytes(kind, bvh_width) / kNodeUnit);
    shape.offsets |= offset << (4 * slot);
    offset += units;
    internal |= (kind == NodeKind::internal ? 1U : 0U) << slot;
    instance |= (kind == NodeKind::instance ? 1U : 0U) << slot;
    wide |= (units == 2 ? 1U : 0U) << slot;
  }
  shape.internal_mask = static_cast<std::uint8_t>(internal);
  shape.instance_mask = static_cast<std::uint8_t>(instance);
  shape.wide_mask = static_cast<std::uint8_t>(wide);
  shape.units = static_cast<std::uint8_t>(offset);
  return shape;
}

void ShapeTable::set_width(unsigned bvh_width) {
  if (width_ == bvh_width) return;
  width_ = bvh_width;
  entries_.assign(std::size_t{1} << kBits, Entry{});
}

const NodeShape& ShapeTable::of(const NodeDefinition& node) {
  std::uint64_t kinds = 0;
  static_assert(sizeof node.child_kinds == sizeof kinds);
  std::memcpy(&kinds, node.child_kinds.data(), sizeof kinds);
  Entry& entry = entries_[((kinds + node.child_count) * 0x9E3779B97F4A7C15ULL) >> (64 - kBits)];
  if (entry.kinds != kinds || entry.count != node.child_count) {
    entry = {kinds, node.child_count, make_shape(width_, node.child_kinds, node.child_count)};
  }
  return entry.shape;
}

}  // namespace grtx::traces
