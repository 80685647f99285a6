// A cycle in four bytes, for tables of which the host's caches should hold as much as possible.
#pragma once

#include <cstdint>

#include "grtx/base/strong.h"

namespace grtx::sim {

/// The low half of a cycle. Which one it was is known as long as it lies within 2^31 cycles of the present.
class NearCycle {
 public:
  static constexpr Cycle kReach = Cycle{1} << 31;

  NearCycle() = default;
  explicit NearCycle(Cycle cycle) : low_(static_cast<std::uint32_t>(cycle)) {}

  /// now: the present.
  Cycle at(Cycle now) const {
    const auto ahead = static_cast<std::int32_t>(low_ - static_cast<std::uint32_t>(now));
    return now + static_cast<Cycle>(static_cast<std::int64_t>(ahead));
  }

 private:
  std::uint32_t low_ = 0;
};

}  // namespace grtx::sim
