// The entry with the least t is read first; of equal t, the one written first. No order that hardware could have for
// nothing: it shows what a sorted buffer would give.
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
  /// Once arranged. The hardware model, which knows no t when it reads, takes places in this order too.
  static constexpr std::size_t position(std::size_t read, std::size_t /*size*/) { return read; }
};

}  // namespace grtx::traces
