// SPDX-License-Identifier: Apache-2.0
// Random numbers that are the same on every host: the standard library's distributions differ between libraries.
#pragma once

#include <cstdint>

namespace grtx {

inline constexpr std::uint64_t kSplitMixStep = 0x9e3779b97f4a7c15u;

/// Hash of a number: the first one that SplitMix64 (Steele, Lea and Flood, OOPSLA 2014) gives for this seed.
constexpr std::uint64_t split_mix(std::uint64_t x) {
  x += kSplitMixStep;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

/// SplitMix64 itself: a sequence for each seed.
class SplitMix64 {
 public:
  constexpr explicit SplitMix64(std::uint64_t seed) : state_(seed) {}

  constexpr std::uint64_t next() {
    const std::uint64_t number = split_mix(state_);
    state_ += kSplitMixStep;
    return number;
  }
  constexpr double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }  ///< [0, 1)
  /// A number below `bound`, which is at most 2^32; the bias is bound / 2^32.
  constexpr std::uint64_t below(std::uint64_t bound) { return ((next() >> 32) * bound) >> 32; }

 private:
  std::uint64_t state_;
};

}  // namespace grtx
