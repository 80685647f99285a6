// SPDX-License-Identifier: Apache-2.0
// Fills in flight in a sampled run, in which one simulated cycle counts as `stride` cycles of the machine. An access to
// a sector that is already requested waits for what is left of the usual miss latency: latency - elapsed cycles *
// stride.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "grtx/base/strong.h"
#include "grtx/modules/cache/decide/sector_cache_tags.h"
#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

class DilatedFills {
 public:
  using Slot = SectorCacheTags::Slot;

  /// slots: number of lines in the cache. Nothing is tracked if stride is 1.
  DilatedFills(unsigned stride, std::size_t slots) : stride_(stride), lines_(stride > 1 ? slots : 0) {}

  /// A timed miss completed after `latency` cycles: updates the running average.
  void landed(Cycle latency) { usual_ += (static_cast<double>(latency) - usual_) / kMemory; }
  /// A touch requested these sectors of the line in cycle `at`.
  void ask(Slot slot, std::uint8_t sectors, Cycle at) {
    Line& line = lines_[slot];
    if (left(line.asked, at) <= 0.0) line.sectors = 0;
    line.sectors |= sectors;
    line.asked = at;
  }
  /// The slot now holds another line.
  void forget(Slot slot) { lines_[slot].sectors = 0; }
  /// Cycles until the sector arrives; 0 if it is present.
  Cycle remaining(Slot slot, std::uint8_t sector, Cycle now) {
    Line& line = lines_[slot];
    if ((line.sectors & sector) == 0) return 0;
    const double cycles = left(line.asked, now);
    if (cycles >= 1.0) return static_cast<Cycle>(cycles);
    line.sectors = 0;
    return 0;
  }

  /// Keeps a response until cycle `due`.
  void hold(const MemoryResponse& response, Cycle due) {
    held_.push_back({due, response});
    std::push_heap(held_.begin(), held_.end());
  }
  /// Calls f(response) for each held response that is due, earliest first.
  template <typename F>
  void release(Cycle now, F&& f) {
    while (!held_.empty() && held_.front().due <= now) {
      const MemoryResponse response = held_.front().response;
      std::pop_heap(held_.begin(), held_.end());
      held_.pop_back();
      f(response);
    }
  }
  /// Cycle in which the next held response is due; kNever if none is held.
  Cycle next_due() const { return held_.empty() ? ~Cycle{0} : held_.front().due; }
  bool idle() const { return held_.empty(); }
  void restart() {
    std::fill(lines_.begin(), lines_.end(), Line());
    held_.clear();
    usual_ = kFirstGuess;
  }

 private:
  static constexpr double kFirstGuess = 400.0;  ///< cycles; latency assumed before the first miss
  static constexpr double kMemory = 256.0;      ///< window of the running average, in misses
  struct Line {
    Cycle asked = 0;
    std::uint8_t sectors = 0;  ///< requested in that cycle
  };
  struct Held {
    Cycle due = 0;
    MemoryResponse response;
    bool operator<(const Held& other) const { return due > other.due; }  // inverted: std heaps keep the largest on top
  };
  double left(Cycle asked, Cycle now) const { return usual_ - static_cast<double>(now - asked) * stride_; }

  unsigned stride_;
  double usual_ = kFirstGuess;
  std::vector<Line> lines_;
  std::vector<Held> held_;  ///< heap, earliest due on top
};

}  // namespace grtx::modules
