// Which of the work takes time where one event in `stride` does: then a cycle of the simulation stands for `stride`
// cycles of the machine.
#pragma once

#include <cstdint>

namespace grtx::modules {

struct Sampling {
  unsigned stride = 1;  ///< 1: everything takes time
  unsigned offset = 0;  ///< which one of the stride; below it

  bool on() const { return stride > 1; }
  /// Where in its stride a sequence of events begins, the same for all that have this key.
  unsigned first(std::uint64_t key) const { return static_cast<unsigned>((mixed(key) + offset) % stride); }

 private:
  // The finalizer of SplitMix64: neighbouring keys begin in unrelated places.
  static constexpr std::uint64_t mixed(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }
};

/// Sectors that a cache's demand reads missed in a sampled run: of all events, and of those that took time.
struct TimedMisses {
  std::uint64_t all = 0, timed = 0;
};

}  // namespace grtx::modules
