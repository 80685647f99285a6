// SPDX-License-Identifier: Apache-2.0
// Spill decisions for a lane's traversal stack: the top stays in the warp buffer, and entries move to and from memory
// one sector at a time. Untimed: the stack unit sends the sectors.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/base/error.h"

namespace grtx::modules {

class StackSpill {
 public:
  struct Lane {
    std::uint32_t in_memory = 0;  ///< spilled entries, a multiple of in_a_sector
  };
  /// `spills` sectors to write, or one to read (`fill`), from sector `first` of the lane's stack area on.
  struct Move {
    std::uint32_t first = 0;
    unsigned spills = 0;
    bool fill = false;
    bool any() const { return spills > 0 || fill; }
  };

  /// on_chip: entries per lane in the warp buffer. in_a_sector: entries per sector (StackEntryLayout). Throws Error if
  /// on_chip < in_a_sector.
  StackSpill(unsigned on_chip, unsigned in_a_sector) : on_chip_(on_chip), in_a_sector_(in_a_sector) {
    if (on_chip >= in_a_sector) return;
    throw Error(
        "configuration", "rt.warp_buffer.stack_entries",
        "must be at least " + std::to_string(in_a_sector) + " when the stack spills as many entries per sector");
  }

  /// The lane's stack now has `depth` entries. takes_top: its next event takes the top entry. Fills happen only then;
  /// nothing is read ahead.
  Move settle(Lane& lane, std::uint32_t depth, bool takes_top) const {
    Move move;
    std::uint32_t here = depth - lane.in_memory;
    if (here > on_chip_) {
      move.first = lane.in_memory / in_a_sector_;
      for (; here > on_chip_; here -= in_a_sector_) ++move.spills;
      lane.in_memory += move.spills * in_a_sector_;
    } else if (here == 0 && takes_top && lane.in_memory > 0) {
      lane.in_memory -= in_a_sector_;
      move.first = lane.in_memory / in_a_sector_;
      move.fill = true;
    }
    return move;
  }

 private:
  unsigned on_chip_;
  unsigned in_a_sector_;
};

}  // namespace grtx::modules
