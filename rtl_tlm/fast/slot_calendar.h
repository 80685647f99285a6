// A resource of fast mode that serves so many items a cycle. Reservations need not come in the order of time: an
// earlier cycle that nobody has taken is not lost, as it would be with one "free from" number.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "base/strong.h"

namespace grtx::tlm {

class SlotCalendar {
 public:
  /// places: items served in `width` cycles, 1 to 65535.
  explicit SlotCalendar(unsigned places = 1, unsigned width = 1)
      : places_(places), width_(width), used_(places > 1 ? kWindow : 0) {}

  /// The first cycle from `from` on with a place, which is taken. Past cycles are not given.
  Cycle reserve(Cycle from) {
    if (places_ != 1 || width_ != 1) return reserve_place(from);
    from = std::max(from, base_);
    std::uint64_t& word = full_[from % kWindow / 64];
    const std::uint64_t bit = std::uint64_t{1} << from % 64;
    if ((word & bit) != 0 || from >= base_ + kWindow) return reserve_place(from);
    word |= bit;
    return from;
  }
  /// Cycles before `now` are past.
  void advance(Cycle now) {
    if (now < (base_ + 64) * width_) return;
    const Cycle slot = now / width_;
    while (base_ + 64 <= slot) {
      full_[base_ % kWindow / 64] = 0;
      if (places_ > 1) std::fill_n(used_.begin() + static_cast<std::ptrdiff_t>(base_ % kWindow), 64, std::uint16_t{0});
      base_ += 64;
    }
  }

 private:
  static constexpr Cycle kWindow = 8192;  ///< slots that are kept; later ones are given out in order

  Cycle reserve_place(Cycle from) {
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
    if (places_ == 1 || ++used_[slot % kWindow] == places_) {
      full_[slot % kWindow / 64] |= std::uint64_t{1} << slot % 64;
    }
    return width_ == 1 ? slot : std::max(slot * width_, from);
  }
  Cycle beyond(Cycle slot) {
    slot = std::max(slot, beyond_);
    beyond_ = slot + 1;
    return slot;
  }

  unsigned places_;
  unsigned width_;
  Cycle base_ = 0;  ///< first slot that is kept, a multiple of 64
  Cycle beyond_ = 0;
  std::array<std::uint64_t, kWindow / 64> full_{};
  std::vector<std::uint16_t> used_;
};

}  // namespace grtx::tlm
