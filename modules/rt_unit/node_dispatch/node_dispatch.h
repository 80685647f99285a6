// SPDX-License-Identifier: Apache-2.0
// Node dispatch of the RT unit: passes lanes whose node has arrived to the intersection unit for the node's kind. Lanes
// at a procedural leaf of a monolithic BVH first go to the transform unit, because the primitive is a unit sphere;
// lanes at a box leaf skip the units, because a shader does the test. Paper: Section IV-B, "Baseline Architecture".
// Cost: wires and a selection among five units; no storage.
#pragma once

#include <systemc>

#include "grtx/modules/rt_unit/intersection/intersection_if.h"
#include "grtx/modules/rt_unit/memory_scheduler/node_fetch_if.h"
#include "grtx/modules/rt_unit/part/rt_part.h"
#include "grtx/modules/rt_unit/warp_buffer/warp_buffer_if.h"
#include "grtx/modules/rt_unit/warp_buffer/warp_table.h"

namespace grtx::modules {

class NodeDispatch final : public RtPart, public fetched_node_if, public node_test_if, public intersection_client_if {
 public:
  struct Config {
    bool box_op_per_child = false;   ///< a box operation tests one child, not the whole node
    bool transforms_leaves = false;  ///< procedural leaves hold a matrix: the ray is transformed, then tested
    unsigned leaf_tests = 1;         ///< tests per primitive leaf, done one after another
    bool box_leaves = false;         ///< primitive leaves are boxes: no unit tests them
  };

  NodeDispatch(const sc_core::sc_module_name& name, const Config& config);

  bool transforms_leaves() const { return config_.transforms_leaves; }

  template <typename T>
  using Optional = sc_core::sc_port<T, 1, sc_core::SC_ZERO_OR_MORE_BOUND>;
  sc_core::sc_port<warp_buffer_if> warp_buffer{"warp_buffer"};
  sc_core::sc_port<intersection_client_if> client{"client"};  ///< called for box leaves
  // Ports for node kinds that the acceleration structure lacks stay unbound.
  Optional<intersection_if> ray_box{"ray_box"};
  Optional<intersection_if> ray_triangle{"ray_triangle"};
  Optional<intersection_if> ray_sphere{"ray_sphere"};
  Optional<intersection_if> ray_gaussian{"ray_gaussian"};
  Optional<intersection_if> ray_transform{"ray_transform"};

  /// Throws Error for a kind whose unit port is unbound.
  void fetched(Cycle now, unsigned entry, LaneMask lanes, traces::NodeKind kind) override;
  void test(Cycle now, LaneId test, traces::NodeKind kind, unsigned children) override;
  void begin_node(traces::NodeKind kind) override { unit_of(traces::without_width(kind)).begin_node(); }
  /// Called by the transform unit: the ray of a lane at a leaf has been transformed.
  void unit_result(Cycle now, LaneId id) override;

  bool idle() const override { return true; }  ///< nothing stays inside
  std::uint64_t progress() const override { return 0; }
  Inventory inventory() const override { return {name(), {}, {}}; }
  void dump_state(std::ostream& out) const override;

 private:
  void end_of_elaboration() override;
  intersection_if& unit_of(traces::NodeKind kind) const;
  unsigned tests_of(traces::NodeKind kind, unsigned children) const;

  Config config_;
  WarpTable* warps_ = nullptr;
  intersection_client_if* client_ = nullptr;
  intersection_if* by_kind_[8] = {};             ///< [NodeKind]
  intersection_if* behind_transform_ = nullptr;  ///< the unit that tests a transformed leaf
};

}  // namespace grtx::modules
