// A resource of fast mode that serves so many items a cycle. Reservations need not come in the order of time: an
// earlier cycle that nobody has taken is not lost, as it would be with one "free from" number.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "base/strong.h"
#include "rtl_tlm/fast/port_calendar.h"

namespace grtx::tlm {

class SlotCalendar {
 public:
  /// places: items served in `width` cycles, 1 to 65535.
  explicit SlotCalendar(unsigned places = 1, unsigned width = 1)
      : places_(places),
        width_(width),
        planes_(static_cast<unsigned>(std::bit_width(places))),
        used_(std::size_t{kWindow / 64} * (planes_ + 1)) {}

  /// The first cycle from `from` on with a place, which is taken. Past cycles are not given.
  Cycle reserve(Cycle from) {
    const Cycle first = std::max(width_ == 1 ? from : (from + width_ - 1) / width_, base_);
    if (first >= base_ + kWindow) return beyond(first) * width_;
    Cycle slot = first;
    std::uint64_t free = ~*full(slot) >> slot % 64;
    while (free == 0) {
      slot += 64 - slot % 64;
      if (slot >= base_ + kWindow) return beyond(slot) * width_;
      free = ~*full(slot);
    }
    slot += static_cast<Cycle>(std::countr_zero(free));
    take(full(slot), std::uint64_t{1} << slot % 64);
    return width_ == 1 ? slot : std::max(slot * width_, from);
  }
  /// Cycles before `now` are past.
  void advance(Cycle now) {
    if (now < next_advance_) return;
    const Cycle slot = now / width_;
    while (base_ + 64 <= slot) {
      std::fill_n(full(base_), planes_ + 1, 0);
      base_ += 64;
    }
    next_advance_ = (base_ + 64) * width_;
  }

 private:
  static constexpr Cycle kWindow = PortCalendar::kWindow;

  /// Of 64 slots: which are full, and behind that one word for each digit of how many items they serve.
  std::uint64_t* full(Cycle slot) { return &used_[slot % kWindow / 64 * (planes_ + 1)]; }
  void take(std::uint64_t* words, std::uint64_t bit) {
    std::uint64_t carry = bit;
    std::uint64_t differs = 0;
    for (unsigned digit = 0; digit < planes_; ++digit) {
      std::uint64_t& word = words[digit + 1];
      const std::uint64_t old = word;
      word = old ^ carry;
      carry &= old;
      differs |= word ^ -std::uint64_t{places_ >> digit & 1u};
    }
    words[0] |= bit & ~differs;
  }
  Cycle beyond(Cycle slot) {
    slot = std::max(slot, beyond_);
    beyond_ = slot + 1;
    return slot;
  }

  unsigned places_;
  unsigned width_;
  unsigned planes_;  ///< digits of places_
  Cycle base_ = 0;   ///< first slot that is kept, a multiple of 64
  Cycle next_advance_ = 0;
  Cycle beyond_ = 0;
  std::vector<std::uint64_t> used_;
};

}  // namespace grtx::tlm
