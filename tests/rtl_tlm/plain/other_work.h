// Cycles that other work has, a second time: docs/model/other-work.md.
#pragma once

#include <cmath>
#include <cstdint>

#include "rtl_tlm/plain/channel.h"

namespace grtx::sim::plain {

/// resource: 1 issue slots, 2 L1, 3 DRAM. unit: which of them.
inline bool other_work(double share, std::uint64_t resource, std::uint64_t unit, Cycle cycle) {
  std::uint64_t x = (resource * 4294967296 + unit) * 0x9E3779B97F4A7C15 + cycle;
  x = (x ^ x / (1ULL << 30)) * 0xBF58476D1CE4E5B9;
  x = (x ^ x / (1ULL << 27)) * 0x94D049BB133111EB;
  x ^= x / (1ULL << 31);
  return static_cast<double>(x / (1ULL << 32)) < std::floor(share * 4294967296.0);
}

}  // namespace grtx::sim::plain
