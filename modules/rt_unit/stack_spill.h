// Which entries of a lane's traversal stack lie in memory: the top stays in the warp buffer, two entries move together.
// Without time: the stack unit sends the sectors.
#pragma once

#include <cstdint>

namespace grtx::modules {

class StackSpill {
 public:
  /// Entries of 16 B (8 B address, 4 B t, padded) that move together: one sector.
  static constexpr unsigned kEntriesOfSector = 2;

  struct Lane {
    std::uint32_t in_memory = 0;  ///< entries; a multiple of kEntriesOfSector
  };
  /// Sectors of the lane's stack area, from `first` on: to be written, or one to be read.
  struct Move {
    std::uint32_t first = 0;
    unsigned spills = 0;
    bool fill = false;
    bool any() const { return spills > 0 || fill; }
  };

  /// on_chip: entries of a lane in the warp buffer, >= kEntriesOfSector.
  explicit StackSpill(unsigned on_chip) : on_chip_(on_chip) {}

  /// The lane's stack has `depth` entries now; takes_top: its next event takes the top one. Only then a fill is needed:
  /// nothing is read ahead.
  Move settle(Lane& lane, std::uint32_t depth, bool takes_top) const {
    Move move;
    std::uint32_t here = depth - lane.in_memory;
    if (here > on_chip_) {
      move.first = lane.in_memory / kEntriesOfSector;
      for (; here > on_chip_; here -= kEntriesOfSector) ++move.spills;
      lane.in_memory += move.spills * kEntriesOfSector;
    } else if (here == 0 && takes_top && lane.in_memory > 0) {
      lane.in_memory -= kEntriesOfSector;
      move.first = lane.in_memory / kEntriesOfSector;
      move.fill = true;
    }
    return move;
  }

 private:
  unsigned on_chip_;
};

}  // namespace grtx::modules
