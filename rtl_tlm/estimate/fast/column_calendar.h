// The column commands of a DRAM channel in fast mode, in places of a burst each, so that none is lost between two: a
// burst keeps its distances to all others, earlier and later, also where the bus turns around. Reservations need not
// come in the order of time.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "grtx/modules/dram/decide/dram_config.h"
#include "grtx/rtl_tlm/estimate/fast/cycle_bits.h"

namespace grtx::sim {

class ColumnCalendar {
 public:
  explicit ColumnCalendar(const modules::DramTiming& t)
      : ccd_(t.ccd),
        same_way_{1, places(t.ccd_of_group())},
        write_to_read_{places(t.write_to_read()), places(t.write_to_read_of_group())},
        read_to_write_(places(t.read_to_write())),
        reach_(std::max({same_way_[1], write_to_read_[1], read_to_write_})) {}

  /// The first clock from `from` on for a burst that reads from a bank of `group`; it is taken. Past clocks are not
  /// given.
  Cycle read(Cycle from, unsigned group) {
    const Cycle at = reserve(from / ccd_, {group, Way::read});
    last_read_ = std::max(last_read_, at);
    return std::max(from, at * ccd_);
  }
  /// The same of one that writes. Where others write at `from` or later it goes with them, which turns the bus once for
  /// all: as those behind them have been told when they come, it takes the time that it costs these from the next that
  /// is free. Else reads go first: the bus turns around behind the last that has a place.
  Cycle write(Cycle from, unsigned group) {
    if (const Cycle at = writes_.first_taken(from / ccd_, last_write_ + 1); at != CycleBits::kNone) {
      reserve(at, {group, Way::joined});
      return std::max(from, at * ccd_);
    }
    const Cycle at = reserve(std::max(from / ccd_, last_read_ + read_to_write_), {group, Way::write});
    last_write_ = std::max(last_write_, at);
    return std::max(from, at * ccd_);
  }
  /// No burst is on the bus from this clock on.
  Cycle end() const { return end_ * ccd_; }
  /// Nothing begins before clock `now` any more; what began shortly before it still counts.
  void advance(Cycle now) {
    now /= ccd_;
    now -= std::min({now, reach_, CycleBits::kWindow / 2});
    places_.advance(now);
    writes_.advance(now);
  }

 private:
  enum class Way : std::uint8_t { read, write, joined };
  struct Burst {
    Burst() = default;
    Burst(unsigned number, Way direction) : group(static_cast<std::uint8_t>(number)), way(direction) {}
    std::uint8_t group = 0;
    Way way = Way::read;
  };

  Cycle reserve(Cycle from, Burst burst) {
    // Where bank groups do not matter, a read or what joins meets only writes beyond its place.
    const bool apart = same_way_[1] == 1 && burst.way != Way::write;
    Cycle at = std::max(from, places_.begin());
    for (;;) {
      if (apart) at = places_.first_free(at);
      if (at >= places_.end()) break;
      const Cycle free = allowed(at, burst, apart ? writes_ : places_);
      if (free == at) return take(at, burst);
      at = free;
    }
    at = places_.take_beyond(at);
    end_ = std::max(end_, at + 1);
    return at;
  }
  Cycle take(Cycle at, Burst burst) {
    places_.take(at);
    if (burst.way == Way::write) writes_.take(at);
    bursts_[at % CycleBits::kWindow] = burst;
    end_ = std::max(end_, at + 1);
    return at;
  }
  /// `at` if these bursts allow it, else a later place before which they do not allow any.
  Cycle allowed(Cycle at, Burst burst, const CycleBits& bursts) const {
    const Cycle begin = at - std::min(at, reach_ - 1);
    Cycle free = at;
    bursts.for_each_taken(begin, at + reach_, [&](Cycle other) {
      const Burst& its = bursts_[other % CycleBits::kWindow];
      if (other <= at ? other + distance(its, burst) > at : at + distance(burst, its) > other) {
        free = std::max(free, other + distance(its, burst));
      }
      return true;
    });
    return free;
  }
  Cycle distance(const Burst& first, const Burst& then) const {
    const std::size_t same = first.group == then.group ? 1 : 0;
    if (first.way == then.way || first.way == Way::joined || then.way == Way::joined) return same_way_[same];
    return first.way == Way::write ? write_to_read_[same] : read_to_write_;
  }

  /// The nearest number of places.
  Cycle places(Cycle clocks) const { return std::max<Cycle>(1, (clocks + ccd_ / 2) / ccd_); }

  Cycle ccd_;
  // In places, as all below.
  std::array<Cycle, 2> same_way_, write_to_read_;  ///< of other bank groups, of the same
  Cycle read_to_write_;
  Cycle reach_;    ///< the longest distance
  Cycle end_ = 0;  ///< behind the last place taken
  Cycle last_read_ = 0;
  Cycle last_write_ = 0;                            ///< none that the bus was turned around for is later
  CycleBits places_, writes_;                       ///< those taken; of these, for which the bus turns around
  std::array<Burst, CycleBits::kWindow> bursts_{};  ///< of places taken
};

}  // namespace grtx::sim
