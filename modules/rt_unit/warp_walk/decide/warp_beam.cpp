// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/warp_walk/decide/warp_beam.h"

#include <utility>

namespace grtx::modules {

void BeamTests::add_to(Inventory& inventory, std::uint64_t warps) const {
  if (!config_.enabled) return;
  // Least and most origin and reciprocal direction on each axis, and whether their signs differ.
  constexpr unsigned kBeamBits = 3 * (4 * 32 + 1);
  inventory.storage.push_back({"beams", StorageKind::ram, warps * kBeamBits, 1, 1, false, kBeamBits});
  auto& operators = inventory.operators;
  // Two lanes a cycle go into the beam of a warp that comes.
  operators.push_back({"fp_compare", 32, std::uint64_t{2} * 12});
  // A pipeline chooses between the ends of an interval: by axis for the origin, by product for the reciprocal. Each of
  // its boxes is one of the node's, as six codes, and of one of the lanes, with origin, reciprocal, t_min and t_max.
  const std::uint64_t other_lanes = config_.lanes_per_test - 1, boxes = std::uint64_t{pipelines_} * boxes_;
  operators.push_back({"mux", 32, 6 * std::uint64_t{pipelines_} + 6 * boxes + 8 * boxes * other_lanes});
  if (other_lanes == 0) return;
  operators.push_back({"mux", 48, boxes * (boxes_ - 1)});
  // The least t of each child, of the lanes that are tested at once.
  operators.push_back({"fp_compare", 32, boxes * other_lanes});
}

PartInfo with_beam(PartInfo part, const WarpBeamConfig& config) {
  if (!config.enabled) {
    part.idle_keys.push_back({"rt.beam.least_lanes", "rt.beam.enabled = false"});
    part.idle_keys.push_back({"rt.beam.lanes_per_test", "rt.beam.enabled = false"});
    return part;
  }
  part.energy.push_back({.name = "rt.beam",
                         .statistics = {"gpu.rt.walk.beam_tests"},
                         .terms = {reads(part.name, "beams"), reads(part.name, "nodes")},
                         .basis = "nodes that are tested against a beam: beam and node",
                         .off_by_default = true});
  return part;
}

}  // namespace grtx::modules
