// SPDX-License-Identifier: Apache-2.0
// Warp selection policy round_robin.
#pragma once

#include <bit>
#include <cassert>

#include "grtx/modules/rt_unit/scheduler/decide/warp_selection.h"

namespace grtx::modules {

/// Selects the next candidate after the last selected entry, by entry number.
class RoundRobin final : public WarpSelection {
 public:
  unsigned select(LaneMask candidates, const std::vector<std::uint64_t>&, const SelectableWarps&) override {
    assert(candidates != 0);
    const LaneMask after = last_ >= 63 ? 0 : candidates & (~LaneMask{0} << (last_ + 1));
    last_ = static_cast<unsigned>(std::countr_zero(after != 0 ? after : candidates));
    return last_;
  }

 private:
  unsigned last_ = 63;
};

}  // namespace grtx::modules
