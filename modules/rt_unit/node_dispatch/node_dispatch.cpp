// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/node_dispatch/node_dispatch.h"

#include <algorithm>
#include <ostream>

#include "grtx/base/error.h"

namespace grtx::modules {

using traces::NodeKind;

NodeDispatch::NodeDispatch(const sc_core::sc_module_name& name, const Config& config) : RtPart(name), config_(config) {}

void NodeDispatch::end_of_elaboration() {
  warps_ = &warp_buffer->warps();
  client_ = client.operator->();
  const auto attach = [this](NodeKind kind, Optional<intersection_if>& unit) {
    if (unit.size() > 0) by_kind_[static_cast<std::size_t>(kind)] = unit.operator->();
  };
  attach(NodeKind::internal, ray_box);
  attach(NodeKind::triangle, ray_triangle);
  attach(NodeKind::procedural, ray_sphere);
  attach(NodeKind::procedural, ray_gaussian);
  behind_transform_ = by_kind_[static_cast<std::size_t>(NodeKind::procedural)];
  attach(NodeKind::instance, ray_transform);
  if (config_.transforms_leaves) attach(NodeKind::procedural, ray_transform);
}

void NodeDispatch::unit_result(Cycle now, LaneId id) { behind_transform_->enqueue(now, id, 1); }

intersection_if& NodeDispatch::unit_of(NodeKind kind) const {
  intersection_if* const unit = by_kind_[static_cast<std::size_t>(kind)];
  if (unit == nullptr) throw Error("RT unit", name(), "has no intersection unit for a node that was fetched");
  return *unit;
}

unsigned NodeDispatch::tests_of(NodeKind kind, unsigned children) const {
  if (kind == NodeKind::triangle || kind == NodeKind::procedural) return config_.leaf_tests;
  return kind == NodeKind::internal && config_.box_op_per_child ? std::max(1u, children) : 1;
}

// Wide leaves are tested as the others: only what decodes their bytes differs.
void NodeDispatch::test(Cycle now, LaneId test, NodeKind stored, unsigned children) {
  const NodeKind kind = traces::without_width(stored);
  if (config_.box_leaves && kind == NodeKind::procedural) return client_->unit_result(now, test);
  unit_of(kind).enqueue(now, test, tests_of(kind, children));
}

void NodeDispatch::fetched(Cycle now, unsigned entry, LaneMask lanes, NodeKind stored) {
  const NodeKind kind = traces::without_width(stored);
  if (config_.box_leaves && kind == NodeKind::procedural) {
    warps_->move(entry, lanes, LaneState::waiting_memory, LaneState::in_unit);
    return for_each_bit(lanes, [&](unsigned i) { client_->unit_result(now, lane_id(entry, i)); });
  }
  intersection_if& unit = unit_of(kind);
  unit.begin_node();
  const Warp& warp = warps_->warp(entry);
  warps_->move(entry, lanes, LaneState::waiting_memory, LaneState::in_unit);
  for_each_bit(lanes, [&](unsigned i) {
    const Lane& lane = warp.lane[i];
    prefetch_for_read(lane.next + 2);  // needed after the test
    unsigned children = 0;
    if (kind == NodeKind::internal) {
      const traces::NodeDefinition& node = warp.group->nodes[lane.event.node];
      prefetch_for_read(&node);
      if (config_.box_op_per_child) children = node.child_count;
    }
    unit.enqueue(now, lane_id(entry, i), tests_of(kind, children));
  });
}

void NodeDispatch::dump_state(std::ostream& out) const {
  out << name() << ": to";
  for (const auto* port : {&ray_box, &ray_triangle, &ray_sphere, &ray_gaussian, &ray_transform}) {
    if (port->size() > 0) out << ' ' << port->basename();
  }
  out << '\n';
}

}  // namespace grtx::modules
