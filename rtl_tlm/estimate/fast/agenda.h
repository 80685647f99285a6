// What happens when in fast mode: typed events of the SMs, in the order of time.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "grtx/rtl_tlm/estimate/fast/event_wheel.h"

namespace grtx::sim::fast {

enum class What : std::uint8_t {
  lane,  ///< node tested, source entry there, stack entries moved, entries handed over, or any-hit shader done; index:
         ///< LaneId
  warp,  ///< loads there, phase executed, call out of the RT unit, or stores done; index: slot
  any_hit_timer,  ///< the any-hit batch of a warp buffer entry is due; index: entry
  l1_turn,        ///< the L1 looks at its ports
  selection,      ///< the RT unit selects a warp
  l1_fill,        ///< sectors of a line have arrived; index: fill
  touch,          ///< the caches see the next of a lane's events that take no time; index: LaneId
  count
};

/// One of each `what`, SM and index is on the agenda at most.
struct Due {
  What what{};
  std::uint32_t sm = 0;
  std::uint32_t index = 0;
};

class Agenda {
 public:
  /// indices: the most that one kind of event has in an SM.
  Agenda(unsigned sms, std::uint32_t indices)
      : index_bits_(static_cast<unsigned>(std::bit_width(indices - 1))),
        sm_bits_(static_cast<unsigned>(std::bit_width(sms - 1u))),
        wheel_(static_cast<std::size_t>(What::count) << (index_bits_ + sm_bits_)) {}

  Cycle now() const { return wheel_.now(); }
  std::uint64_t steps() const { return wheel_.steps(); }  ///< cycles in which something was due
  /// In cycle `at`, or in the next one if that is past.
  void add(Cycle at, const Due& due) {
    wheel_.add(at, (static_cast<std::uint32_t>(due.what) << sm_bits_ | due.sm) << index_bits_ | due.index);
  }
  /// f(due) for all in the order of time, until none is left. f may add.
  template <typename F>
  void run(F&& f) {
    const std::uint32_t index_mask = (std::uint32_t{1} << index_bits_) - 1;
    const std::uint32_t sm_mask = (std::uint32_t{1} << sm_bits_) - 1;
    wheel_.run([&](EventWheel::Number number) {
      f(Due{static_cast<What>(number >> (index_bits_ + sm_bits_)), number >> index_bits_ & sm_mask,
            number & index_mask});
    });
  }

 private:
  unsigned index_bits_, sm_bits_;
  EventWheel wheel_;
};

}  // namespace grtx::sim::fast
