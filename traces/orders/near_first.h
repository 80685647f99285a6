// SPDX-License-Identifier: Apache-2.0
// Child order near_first: the child that the ray enters first is visited first; for equal t, the lower slot.
#pragma once

#include "grtx/traces/modes.h"

namespace grtx::traces {

struct NearFirst {
  static constexpr ChildOrder kName = ChildOrder::near_first;
  static constexpr bool kBySlots = false;
  static constexpr bool kFollows = false;
  static constexpr unsigned place(unsigned /*slot*/, unsigned /*hit*/, unsigned rank) { return rank; }
  static constexpr unsigned followed(unsigned /*pushed*/, unsigned /*internal*/) { return 0; }
};

}  // namespace grtx::traces
