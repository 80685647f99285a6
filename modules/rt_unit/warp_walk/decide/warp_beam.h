// SPDX-License-Identifier: Apache-2.0
// The beam around the rays of a warp that walks: which tests a node needs with it. Untimed: the warp walk
// scheduler sends the tests. docs/model/warp_walk.md, "Beam".
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/rt_unit/part/part_info.h"
#include "grtx/modules/rt_unit/warp_walk/decide/warp_stack_config.h"

namespace grtx::modules {

class BeamTests {
 public:
  /// boxes: those that one of the `pipelines` of the ray-box unit tests at once. ray_banks: of the rays, of which each
  /// is read once a cycle; 0: no limit.
  BeamTests(const WarpBeamConfig& config, unsigned boxes, unsigned pipelines, unsigned ray_banks)
      : config_(config), boxes_(boxes), pipelines_(pipelines), ray_banks_(ray_banks) {}

  /// Whether the beam is tested before the lanes.
  bool comes_first(LaneMask lanes) const {
    return config_.enabled && static_cast<unsigned>(std::popcount(lanes)) >= config_.least_lanes;
  }
  /// Lanes of one test, if the beam meets so many children (1 or more).
  unsigned lanes_together(unsigned met) const { return std::clamp(boxes_ / met, 1U, config_.lanes_per_test); }
  /// The next lanes to be tested at once: the lowest that do not lie in a bank of one before, `together` at most.
  LaneMask next_lanes(LaneMask left, unsigned together) const {
    LaneMask lanes = 0, banks = 0;
    for_each_bit(left, [&](unsigned lane) {
      const LaneMask bank = ray_banks_ == 0 ? 0 : bit(lane % ray_banks_);
      if (together == 0 || (banks & bank) != 0) return;
      banks |= bank;
      lanes |= bit(lane);
      --together;
    });
    return lanes;
  }
  /// Least number of tests of so many lanes, if the beam meets so many children.
  unsigned least_tests(unsigned lanes, unsigned met) const {
    const unsigned together = met == 0 ? 0 : lanes_together(met);
    return together == 0 ? 0 : (lanes + together - 1) / together;
  }
  bool enabled() const { return config_.enabled; }
  /// Adds storage and operators. warps: of the warp buffer.
  void add_to(Inventory& inventory, std::uint64_t warps) const;

 private:
  WarpBeamConfig config_;
  unsigned boxes_, pipelines_, ray_banks_;
};

/// Adds what beams bring to the part of the warp walk scheduler.
PartInfo with_beam(PartInfo part, const WarpBeamConfig& config);

}  // namespace grtx::modules
