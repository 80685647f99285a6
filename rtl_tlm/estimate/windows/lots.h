// SPDX-License-Identifier: Apache-2.0
// Random numbers for choosing samples. The standard library's distributions differ between implementations.
#pragma once

#include <cstdint>

namespace grtx::sim {

/// SplitMix64 (Steele, Lea and Flood, 2014). The same seed gives the same numbers on every machine.
class Lots {
 public:
  explicit Lots(std::uint64_t seed) : state_(seed) {}
  /// A number below `bound`, which is at most 2^32; the bias is bound / 2^32.
  std::uint64_t below(std::uint64_t bound) { return ((next() >> 32) * bound) >> 32; }

 private:
  std::uint64_t next() {
    std::uint64_t z = state_ += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
};

}  // namespace grtx::sim
