// SPDX-License-Identifier: Apache-2.0
// Checkpoint order lifo: the entry written last is read first.
#pragma once

#include <cstddef>
#include <vector>

#include "grtx/traces/modes.h"

namespace grtx::traces {

struct Lifo {
  static constexpr CheckpointOrder kName = CheckpointOrder::lifo;
  static constexpr bool kByPlace = true;
  static constexpr bool kBackwards = true;
  template <typename Entry>
  static void arrange(std::vector<Entry>& /*source*/) {}
  static constexpr std::size_t position(std::size_t read, std::size_t size) { return size - 1 - read; }
};

}  // namespace grtx::traces
