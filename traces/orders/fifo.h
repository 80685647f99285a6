// SPDX-License-Identifier: Apache-2.0
// Checkpoint order fifo: the entry written first is read first.
#pragma once

#include <cstddef>
#include <vector>

#include "grtx/traces/modes.h"

namespace grtx::traces {

struct Fifo {
  static constexpr CheckpointOrder kName = CheckpointOrder::fifo;
  static constexpr bool kByPlace = true;
  static constexpr bool kBackwards = false;
  template <typename Entry>
  static void arrange(std::vector<Entry>& /*source*/) {}
  static constexpr std::size_t position(std::size_t read, std::size_t /*size*/) { return read; }
};

}  // namespace grtx::traces
