// When the data of a cache's sectors comes in fast mode, by line and sector. Of most lines all have been there for
// long, which the host learns from four bytes a line.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "grtx/base/strong.h"
#include "grtx/rtl_tlm/estimate/fast/near_cycle.h"

namespace grtx::sim {

class Arrivals {
 public:
  Arrivals(std::size_t lines, unsigned sectors) : sectors_(sectors), last_(lines), comes_(lines * sectors) {}

  /// A sector of a line comes in cycle `at`.
  void come(std::size_t line, unsigned sector, Cycle at) {
    comes_[line * sectors_ + sector] = NearCycle(at);
    last_[line] = NearCycle(std::max(at, last_[line].at(passed_)));
  }
  /// These sectors of a line are there.
  void are_there(std::size_t line, std::uint8_t sectors) {
    if (last_[line].at(passed_) <= passed_) return;
    for (; sectors != 0; sectors &= static_cast<std::uint8_t>(sectors - 1)) {
      comes_[line * sectors_ + static_cast<unsigned>(std::countr_zero(sectors))] = NearCycle(passed_);
    }
  }
  /// How many of a line's sectors come after cycle `now`; last: raised to the arrival of the last of them.
  unsigned count_late(std::size_t line, std::uint8_t sectors, Cycle now, Cycle& last) const {
    if (last_[line].at(passed_) <= now) return 0;
    unsigned late = 0;
    for (; sectors != 0; sectors &= static_cast<std::uint8_t>(sectors - 1)) {
      const Cycle at = comes_[line * sectors_ + static_cast<unsigned>(std::countr_zero(sectors))].at(passed_);
      if (at <= now) continue;
      ++late;
      last = std::max(last, at);
    }
    return late;
  }
  /// No cycle before `now` is asked for any more.
  void advance(Cycle now) {
    passed_ = now;
    if (now < next_sweep_) return;
    next_sweep_ = now + NearCycle::kReach / 2;
    for (std::vector<NearCycle>* all : {&last_, &comes_}) {
      for (NearCycle& at : *all) at = NearCycle(std::max(at.at(now), now));
    }
  }

 private:
  unsigned sectors_;
  std::vector<NearCycle> last_;   ///< by line: none of its sectors comes later
  std::vector<NearCycle> comes_;  ///< by line and sector
  Cycle passed_ = 0;
  Cycle next_sweep_ = NearCycle::kReach / 2;  ///< what came long ago is made recent, for NearCycle
};

}  // namespace grtx::sim
