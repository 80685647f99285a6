// A resource of fast mode that serves so many items a cycle. Reservations need not come in the order of time: an
// earlier cycle that nobody has taken is not lost, as it would be with one "free from" number.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <deque>
#include <vector>

#include "grtx/base/strong.h"
#include "grtx/rtl_tlm/estimate/fast/cycle_bits.h"

namespace grtx::sim {

class SlotCalendar {
 public:
  /// places: items served in `width` cycles, 1 to 65535. width: at least 1.
  explicit SlotCalendar(unsigned places = 1, unsigned width = 1)
      : places_(places), width_(width), used_(kWindow), full_(kWindow / 64) {}

  /// The first cycle from `from` on with a place, which is taken. Past cycles are not given.
  Cycle reserve(Cycle from) {
    const Cycle first = std::max(width_ == 1 ? from : (from + width_ - 1) / width_, base_);
    if (first >= base_ + kWindow) return beyond(first) * width_;
    Cycle slot = first;
    std::uint64_t free = ~full_[slot % kWindow / 64] >> slot % 64;
    while (free == 0) {
      slot += 64 - slot % 64;
      if (slot >= base_ + kWindow) return beyond(slot) * width_;
      free = ~full_[slot % kWindow / 64];
    }
    slot += static_cast<Cycle>(std::countr_zero(free));
    take(slot);
    return width_ == 1 ? slot : std::max(slot * width_, from);
  }
  /// Cycles before `now` are past.
  void advance(Cycle now) {
    if (now < next_advance_) return;
    const Cycle slot = now / width_;
    if (slot >= base_ + kWindow) {  // all that is kept is past
      std::fill(used_.begin(), used_.end(), std::uint16_t{0});
      std::fill(full_.begin(), full_.end(), std::uint64_t{0});
      base_ = slot / 64 * 64;
    }
    while (base_ + 64 <= slot) {
      std::fill_n(&used_[base_ % kWindow], 64, std::uint16_t{0});
      full_[base_ % kWindow / 64] = 0;
      base_ += 64;
    }
    for (; !far_.empty() && far_.front() < base_ + kWindow; far_.pop_front()) {
      if (far_.front() >= base_) take(far_.front());
    }
    next_advance_ = (base_ + 64) * width_;
  }

 private:
  static constexpr Cycle kWindow = CycleBits::kWindow;

  void take(Cycle slot) {
    const bool fills = ++used_[slot % kWindow] == places_;
    full_[slot % kWindow / 64] |= std::uint64_t{fills} << slot % 64;
  }
  Cycle beyond(Cycle slot) {
    slot = std::max(slot, beyond_);
    if (slot != last_beyond_) left_beyond_ = places_;
    last_beyond_ = slot;
    if (--left_beyond_ == 0) beyond_ = slot + 1;
    far_.push_back(slot);
    return slot;
  }

  unsigned places_;
  unsigned width_;
  Cycle base_ = 0;  ///< first slot that is kept, a multiple of 64
  Cycle next_advance_ = 0;
  // Slots beyond the window are given out in order, and taken when they come into it.
  Cycle beyond_ = 0;
  Cycle last_beyond_ = ~Cycle{0};
  unsigned left_beyond_ = 0;  ///< places of that slot
  std::deque<Cycle> far_;
  std::vector<std::uint16_t> used_;  ///< by slot
  std::vector<std::uint64_t> full_;  ///< a bit a slot
};

}  // namespace grtx::sim
