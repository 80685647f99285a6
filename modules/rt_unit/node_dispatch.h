// Node dispatch of the RT unit: hands the lanes whose node has arrived to the intersection unit of the node's kind;
// those at a procedural leaf of a monolithic BVH first to the transform unit, because the primitive is a unit sphere;
// those at a box straight on, because a shader tests what lies in it.
// Paper: Section IV-B, "Baseline Architecture". Cost: wires and the choice among four units; no storage.
#pragma once

#include <systemc>

#include "grtx/modules/rt_unit/intersection_if.h"
#include "grtx/modules/rt_unit/node_fetch_if.h"
#include "grtx/modules/rt_unit/warp_buffer_if.h"
#include "grtx/modules/rt_unit/warp_table.h"

namespace grtx::modules {

class NodeDispatch final : public sc_core::sc_module, public fetched_node_if, public intersection_client_if {
 public:
  struct Config {
    bool box_op_per_child = false;   ///< a box operation tests one child, not the whole node
    bool transforms_leaves = false;  ///< procedural leaves hold a matrix: the ray is transformed, then tested
    unsigned leaf_tests = 1;         ///< a primitive leaf's, one after the other
    bool box_leaves = false;         ///< no unit tests a primitive leaf
  };

  NodeDispatch(const sc_core::sc_module_name& name, const Config& config);

  bool transforms_leaves() const { return config_.transforms_leaves; }

  template <typename T>
  using Optional = sc_core::sc_port<T, 1, sc_core::SC_ZERO_OR_MORE_BOUND>;
  sc_core::sc_port<warp_buffer_if> warp_buffer{"warp_buffer"};
  sc_core::sc_port<intersection_client_if> client{"client"};  ///< told of boxes
  // Units of kinds that the structure does not have stay unbound.
  Optional<intersection_if> ray_box{"ray_box"};
  Optional<intersection_if> ray_triangle{"ray_triangle"};
  Optional<intersection_if> ray_sphere{"ray_sphere"};
  Optional<intersection_if> ray_transform{"ray_transform"};

  /// Throws Error for a kind whose unit is unbound.
  void fetched(Cycle now, unsigned entry, LaneMask lanes, traces::NodeKind kind) override;
  /// The ray of a lane at a leaf has been transformed.
  void unit_result(Cycle now, LaneId id) override;

 private:
  void end_of_elaboration() override;

  Config config_;
  WarpTable* warps_ = nullptr;
  intersection_client_if* client_ = nullptr;
  intersection_if* by_kind_[8] = {};  ///< by NodeKind
};

}  // namespace grtx::modules
