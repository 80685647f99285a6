// SPDX-License-Identifier: Apache-2.0
// Requirements on a machine that follow from the structure that it traverses; they decide which units it has.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/base/declare/named_enum.h"
#include "grtx/traces/modes.h"
#include "grtx/traces/node_layout.h"

namespace grtx::sim {

/// Unit that tests primitive leaves: the ray-triangle unit, the ray-sphere unit, or, for boxes, a shader.
enum class LeafTest : std::uint8_t { triangles, spheres, boxes };
constexpr auto enum_names(LeafTest) { return names_in_order<LeafTest>({"triangles", "spheres", "boxes"}); }
constexpr LeafTest leaf_test_of(traces::AccelKind kind) {
  if (traces::has_box_leaves(kind)) return LeafTest::boxes;
  return traces::has_procedural_leaves(kind) ? LeafTest::spheres : LeafTest::triangles;
}
/// By the structure's name; an unknown name counts as triangles.
inline LeafTest leaf_test_of(const std::string& accel) {
  const auto kind = from_name<traces::AccelKind>(accel);
  return kind ? leaf_test_of(*kind) : LeafTest::triangles;
}

/// The properties that decide which units a machine has.
struct MachineUse {
  std::string design = "grtx";  ///< sw (two levels), hw (checkpointing), grtx (both), or another: neither
  LeafTest leaves = LeafTest::triangles;
  traces::PopTest pop_test = traces::PopTest::on;                  ///< on: stack entries hold a t
  traces::OpacityBound opacity_bound = traces::OpacityBound::off;  ///< on: heaps add up opacities
  traces::AnyHit any_hit = traces::AnyHit::immediate;              ///< delayed: hits wait in a queue
  bool peak = false;  ///< hits lie at the peak of a response: without the square root that finds the entry
  traces::NodeLayout layout = traces::NodeLayout::vulkan_sim;
  unsigned bvh_width = 0;        ///< children of an internal node, 2 to 8; 0: as many as a line of the layout holds
  bool objects = false;          ///< sw and grtx: with a scene TLAS on top, three levels
  unsigned checkpoint_bins = 0;  ///< hw and grtx: near bins; 0: two buffers instead
  std::uint64_t checkpoint_capacity = 1024;  ///< entries of a bin

  unsigned width() const { return bvh_width != 0 ? bvh_width : traces::default_width(layout); }
};

}  // namespace grtx::sim
