// Which units a machine has: what the structure that it traverses asks for.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/base/declare/named_enum.h"
#include "grtx/traces/modes.h"
#include "grtx/traces/node_layout.h"

namespace grtx::sim {

/// What tests a primitive leaf: a unit, or of boxes a shader.
enum class LeafTest : std::uint8_t { triangles, spheres, boxes };
constexpr auto enum_names(LeafTest) { return names_in_order<LeafTest>({"triangles", "spheres", "boxes"}); }
constexpr LeafTest leaf_test_of(traces::AccelKind kind) {
  if (traces::has_box_leaves(kind)) return LeafTest::boxes;
  return traces::has_procedural_leaves(kind) ? LeafTest::spheres : LeafTest::triangles;
}
/// A structure without a known name has triangles.
inline LeafTest leaf_test_of(const std::string& accel) {
  const auto kind = from_name<traces::AccelKind>(accel);
  return kind ? leaf_test_of(*kind) : LeafTest::triangles;
}

/// Which units the machine must have.
struct MachineUse {
  std::string design = "grtx";  ///< baseline, sw, hw or grtx: two levels, checkpointing
  LeafTest leaves = LeafTest::triangles;
  traces::PopTest pop_test = traces::PopTest::on;  ///< on: stack entries hold a t
  traces::NodeLayout layout = traces::NodeLayout::vulkan_sim;
  unsigned bvh_width = 0;        ///< children of an internal node, 2 to 8; 0: as many as a line of the layout holds
  bool objects = false;          ///< of sw and grtx: a scene TLAS above, three levels
  unsigned checkpoint_bins = 0;  ///< of hw and grtx: bins in place of two buffers
  std::uint64_t checkpoint_capacity = 1024;  ///< entries of a bin

  unsigned width() const { return bvh_width != 0 ? bvh_width : traces::default_width(layout); }
};

}  // namespace grtx::sim
