// SPDX-License-Identifier: Apache-2.0
// Warp selection policy oldest_first.
#pragma once

#include <bit>
#include <cassert>

#include "grtx/modules/rt_unit/scheduler/decide/warp_selection.h"

namespace grtx::modules {

/// Selects the warp that entered the buffer first (as in Vulkan-Sim).
class OldestFirst final : public WarpSelection {
 public:
  unsigned select(LaneMask candidates, const std::vector<std::uint64_t>& ages, const SelectableWarps&) override {
    return oldest(candidates, ages);
  }
  static unsigned oldest(LaneMask candidates, const std::vector<std::uint64_t>& ages) {
    assert(candidates != 0);
    auto best = static_cast<unsigned>(std::countr_zero(candidates));
    for (LaneMask m = candidates & (candidates - 1); m != 0; m &= m - 1) {
      const auto e = static_cast<unsigned>(std::countr_zero(m));
      if (ages[e] < ages[best]) best = e;
    }
    return best;
  }
};

}  // namespace grtx::modules
