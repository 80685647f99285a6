// SPDX-License-Identifier: Apache-2.0
// Child order slot: children are visited in slot order, regardless of distance.
#pragma once

#include <bit>

#include "grtx/traces/modes.h"

namespace grtx::traces {

struct SlotOrder {
  static constexpr ChildOrder kName = ChildOrder::slot;
  static constexpr bool kBySlots = true;
  static constexpr bool kFollows = false;
  static constexpr unsigned place(unsigned slot, unsigned hit, unsigned /*rank*/) {
    return static_cast<unsigned>(std::popcount(hit & ((1U << slot) - 1)));
  }
  static constexpr unsigned followed(unsigned /*pushed*/, unsigned /*internal*/) { return 0; }
};

}  // namespace grtx::traces
