// When a DRAM channel of fast mode opens rows: an activate keeps its distances to all others, earlier and later, and no
// five begin within tFAW. Reservations need not come in the order of time. Those whose bank is busy leave a gap before
// them. One that fits in by its distances goes first, as in the cycle model, and for tFAW those behind it move on,
// later than they were told, if none of them waited when it begins. If they stayed, each would keep what is missing in
// its gap of a tFAW, and a channel at that limit would lose 4 % of its activates.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "grtx/modules/dram/decide/dram_config.h"
#include "grtx/rtl_tlm/estimate/fast/cycle_bits.h"

namespace grtx::sim {

class ActivateCalendar {
 public:
  explicit ActivateCalendar(const modules::DramTiming& t)
      : distance_{std::max(1u, t.rrd), std::max(1u, t.rrd_of_group())},
        faw_(t.faw),
        reach_(std::max(distance_[1], faw_)) {}

  /// The first clock from `from` on in which a bank of `group` can open a row; it is taken. Past clocks are not given.
  Cycle reserve(Cycle from, unsigned group) {
    if (faw_ == 0 && distance_[0] == distance_[1]) return reserve_apart(from);
    Activate first{std::max(from, clocks_.begin()), group, from};
    while (first.at < clocks_.end()) {
      look_back(first.at);
      const Cycle free = allowed(first);
      if (free != first.at) {
        first.at = free;
      } else if (const Cycle waiting = move_those_behind(first); waiting != CycleBits::kNone) {
        first.at = waiting + 1;
      } else {
        for (const Activate& moved : moved_) put(moved);
        return first.at;
      }
    }
    return clocks_.take_beyond(first.at, std::max(distance_[0], (faw_ + 3) / 4));
  }
  /// Nothing begins before clock `now` any more; what began shortly before it still counts.
  void advance(Cycle now) { clocks_.advance(now - std::min({now, reach_, CycleBits::kWindow / 2})); }

 private:
  struct Activate {
    Cycle at = 0;
    unsigned group = 0;
    Cycle due = 0;
  };
  /// The last four before one.
  struct Before {
    std::array<Activate, 4> newest{};
    std::size_t count = 0;
    void add(const Activate& next) { newest[count++ % 4] = next; }
  };

  /// The same with one distance for all, which none moves for.
  Cycle reserve_apart(Cycle from) {
    const Cycle distance = distance_[0];
    Cycle at = std::max(from, clocks_.begin());
    while (at < clocks_.end()) {
      const Cycle near = clocks_.first_taken(at - std::min(at, distance - 1), at + distance);
      if (near == CycleBits::kNone) {
        clocks_.take(at);
        return at;
      }
      at = near + distance;
    }
    return clocks_.take_beyond(at, distance);
  }
  Activate get(Cycle at) const { return {at, group_[at % CycleBits::kWindow], at - late_[at % CycleBits::kWindow]}; }
  void put(const Activate& a) {
    clocks_.take(a.at);
    group_[a.at % CycleBits::kWindow] = static_cast<std::uint8_t>(a.group);
    late_[a.at % CycleBits::kWindow] = static_cast<std::uint16_t>(std::min<Cycle>(a.at - a.due, 0xffff));
  }
  void look_back(Cycle at) {
    std::array<Cycle, 4> clocks;
    std::size_t found = 0;
    clocks_.for_each_taken_back(at - std::min(at, reach_), at + 1, [&](Cycle clock) {
      clocks[found] = clock;
      return ++found < 4;
    });
    before_.count = 0;
    while (found > 0) before_.add(get(clocks[--found]));
  }
  /// The first clock from the activate's on that those before it allow.
  Cycle allowed(const Activate& next) const {
    Cycle at = next.at;
    for (std::size_t i = 0; i < std::min<std::size_t>(before_.count, 4); ++i) {
      at = std::max(at, before_.newest[i].at + distance_[before_.newest[i].group == next.group ? 1 : 0]);
    }
    return before_.count < 4 ? at : std::max(at, before_.newest[before_.count % 4].at + faw_);
  }
  /// In moved_ the activate and those behind it that it moves, which are taken out. If one of these is too close, or
  /// has been waiting when the activate begins, its clock, and nothing is moved.
  Cycle move_those_behind(const Activate& first) {
    moved_.assign(1, first);
    before_.add(first);
    taken_out_.clear();
    Cycle from = first.at + 1;
    for (std::size_t stay = 0; stay < 4;) {
      const Cycle at = clocks_.first_taken(from, before_.newest[(before_.count - 1) % 4].at + reach_);
      if (at == CycleBits::kNone) break;
      from = at + 1;
      Activate next = get(at);
      const Cycle due = next.due;
      next.at = allowed(next);
      before_.add(next);
      if (next.at == at) {
        ++stay;
        continue;
      }
      const bool too_close = first.at + distance_[first.group == next.group ? 1 : 0] > at;
      if (too_close || due <= first.at || next.at >= clocks_.end()) return at;
      stay = 0;
      taken_out_.push_back(at);
      moved_.push_back(next);
    }
    for (const Cycle at : taken_out_) clocks_.leave(at);
    return CycleBits::kNone;
  }

  std::array<Cycle, 2> distance_;  ///< to one of another bank group, of the same
  Cycle faw_;
  Cycle reach_;  ///< the longest distance
  CycleBits clocks_;
  Before before_;
  std::vector<Activate> moved_;
  std::vector<Cycle> taken_out_;
  std::array<std::uint8_t, CycleBits::kWindow> group_{};
  std::array<std::uint16_t, CycleBits::kWindow> late_{};  ///< since when it has been due
};

}  // namespace grtx::sim
