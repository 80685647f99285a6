// SPDX-License-Identifier: Apache-2.0
// Checkpoint order nearest: the entry with the smallest t is read first; for equal t, the one written first. Not free
// in hardware: it shows what a sorted buffer would gain.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "grtx/traces/modes.h"

namespace grtx::traces {

struct Nearest {
  static constexpr CheckpointOrder kName = CheckpointOrder::nearest;
  static constexpr bool kByPlace = false;
  static constexpr bool kBackwards = false;
  template <typename Entry>
  static void arrange(std::vector<Entry>& source) {
    std::stable_sort(source.begin(), source.end(), [](const Entry& a, const Entry& b) { return a.t < b.t; });
  }
  /// Valid after arrange(). The hardware model, which does not know t when it reads, also reads places in this order.
  static constexpr std::size_t position(std::size_t read, std::size_t /*size*/) { return read; }
};

}  // namespace grtx::traces
