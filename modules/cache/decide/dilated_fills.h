// Sectors on their way to a cache in a sampled run, where `stride` cycles of the machine pass in one of the simulation:
// a fill is back that much sooner for those who ask later, whether its own request takes time or not.
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

  /// slots: lines of the cache; none where stride is 1.
  DilatedFills(unsigned stride, std::size_t slots) : stride_(stride), lines_(stride > 1 ? slots : 0) {}

  /// A miss that took time was back after so many cycles.
  void landed(Cycle latency) { usual_ += (static_cast<double>(latency) - usual_) / kMemory; }
  /// `sectors` of the line have been asked for in cycle `at`.
  void ask(Slot slot, std::uint8_t sectors, Cycle at) {
    Line& line = lines_[slot];
    if (left(line.asked, at) <= 0.0) line.sectors = 0;
    line.sectors |= sectors;
    line.asked = at;
  }
  /// Another line has taken the place.
  void forget(Slot slot) { lines_[slot].sectors = 0; }
  /// Cycles until the sector is there; 0: it is.
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
  /// f(response) for those that are due.
  template <typename F>
  void release(Cycle now, F&& f) {
    while (!held_.empty() && held_.front().due <= now) {
      const MemoryResponse response = held_.front().response;
      std::pop_heap(held_.begin(), held_.end());
      held_.pop_back();
      f(response);
    }
  }
  /// When the next response is due; kNever: none is held.
  Cycle next_due() const { return held_.empty() ? ~Cycle{0} : held_.front().due; }
  bool idle() const { return held_.empty(); }
  void restart() {
    std::fill(lines_.begin(), lines_.end(), Line());
    usual_ = kFirstGuess;
  }

 private:
  static constexpr double kFirstGuess = 400.0;  ///< cycles, until misses have been seen
  static constexpr double kMemory = 256.0;      ///< misses over which the usual latency is averaged
  struct Line {
    Cycle asked = 0;
    std::uint8_t sectors = 0;  ///< asked for then
  };
  struct Held {
    Cycle due = 0;
    MemoryResponse response;
    bool operator<(const Held& other) const { return due > other.due; }  // the heap's top is due first
  };
  double left(Cycle asked, Cycle now) const { return usual_ - static_cast<double>(now - asked) * stride_; }

  unsigned stride_;
  double usual_ = kFirstGuess;
  std::vector<Line> lines_;
  std::vector<Held> held_;  ///< a heap
};

}  // namespace grtx::modules
