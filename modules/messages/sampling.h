// SPDX-License-Identifier: Apache-2.0
// Stride sampling: one event in `stride` is simulated in time, the others only functionally. One simulated cycle then
// stands for `stride` cycles of the machine.
#pragma once

#include <cstdint>

namespace grtx::modules {

struct Sampling {
  unsigned stride = 1;  ///< 1: no sampling, every event is timed
  unsigned offset = 0;  ///< position of the timed event within a stride; below stride

  bool on() const { return stride > 1; }
  /// Start position within the stride for a sequence of events, a hash of `key`.
  unsigned first(std::uint64_t key) const { return static_cast<unsigned>((mixed(key) + offset) % stride); }

  /// The finalizer of SplitMix64: neighbouring keys get unrelated values.
  static constexpr std::uint64_t mixed(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }
};

/// A counter of a sampled run: over all events, and over the timed ones.
struct TimedShare {
  std::uint64_t all = 0, timed = 0;
};

}  // namespace grtx::modules
