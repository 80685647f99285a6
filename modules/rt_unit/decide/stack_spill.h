// Which entries of a lane's traversal stack lie in memory: the top stays in the warp buffer, a sector of entries moves
// at a time. Without time: the stack unit sends the sectors.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/base/error.h"

namespace grtx::modules {

/// Entries of a lane where none spill: a depth-first walk of a 6-wide tree of 28 levels needs at most 140.
inline constexpr unsigned kUnspilledStackEntries = 140;

class StackSpill {
 public:
  struct Lane {
    std::uint32_t in_memory = 0;  ///< entries; a multiple of those in a sector
  };
  /// Sectors of the lane's stack area, from `first` on: to be written, or one to be read.
  struct Move {
    std::uint32_t first = 0;
    unsigned spills = 0;
    bool fill = false;
    bool any() const { return spills > 0 || fill; }
  };

  /// on_chip: entries of a lane in the warp buffer, in_a_sector: entries that move together (StackEntryLayout). Throws
  /// Error if fewer are on chip than move together.
  StackSpill(unsigned on_chip, unsigned in_a_sector) : on_chip_(on_chip), in_a_sector_(in_a_sector) {
    if (on_chip >= in_a_sector) return;
    throw Error("configuration", "rt.warp_buffer.stack_entries",
                "must be at least " + std::to_string(in_a_sector) + " when the stack spills as many entries a sector");
  }

  /// The lane's stack has `depth` entries now; takes_top: its next event takes the top one. Only then a fill is needed:
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
