// A clock domain: one shared tick event for all clocked modules of a domain, with idle skip and no free-running clock.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <set>
#include <systemc>

#include "base/strong.h"

namespace grtx::modules {

inline constexpr Cycle kNever = std::numeric_limits<Cycle>::max();

/// Clocked modules make one SC_METHOD statically sensitive to `tick()` with dont_initialize(). While anybody asked for
/// the next cycle the domain notifies itself one period ahead; when nobody did it jumps to the earliest requested
/// cycle. Times are integers of the kernel's resolution (1 fs, set before elaboration): no floating-point time
/// accumulates.
class ClockDomain final : public sc_core::sc_module {
 public:
  SC_HAS_PROCESS(ClockDomain);
  /// mhz: frequency, rounded to an integer period in fs. idle_skip false ticks every cycle (for tests).
  ClockDomain(const sc_core::sc_module_name& name, double mhz, bool idle_skip = true);

  const sc_core::sc_event& tick() const { return tick_; }
  /// Index of the current cycle (of the last tick that fired). Valid inside processes sensitive to tick().
  Cycle cycle() const { return cycle_; }
  std::uint64_t period_fs() const { return period_fs_; }
  /// Asks for a tick at `cycle` (> cycle() when called from a tick process; an earlier one is moved to cycle() + 1).
  /// May be called from outside the domain (TLM callbacks): the edge is the first one not before the present time.
  /// A request stays booked until its cycle, whatever other cycles tick before it; kNever asks for nothing.
  void request(Cycle cycle) {
    if (cycle >= next_) {
      if (cycle != next_) book(cycle);
      return;
    }
    request_earlier(cycle);
  }
  /// First edge at or after the present simulation time, for callers outside the domain.
  Cycle edge_at_or_after_now() const;
  /// First edge strictly after present time + delay_fs: what a call from outside the domain becomes visible at. Strict,
  /// so that it does not matter whether the caller or this domain runs first when both have an edge now.
  Cycle edge_after_now(std::uint64_t delay_fs = 0) const {
    return (sc_core::sc_time_stamp().value() + delay_fs) / period_fs_ + 1;
  }
  std::uint64_t ticks() const { return ticks_; }  ///< ticks that fired (cycles not skipped)

 private:
  // Booked cycles within kWheel of the present one are bits of a wheel; the few farther ones are in a set.
  static constexpr Cycle kWheel = 1024;

  void book(Cycle cycle) {
    if (cycle - cycle_ < kWheel) {
      wheel_[(cycle % kWheel) / 64] |= std::uint64_t{1} << (cycle % 64);
    } else if (cycle != kNever) {
      far_.insert(cycle);
    }
  }
  Cycle earliest_booked() const;
  void schedule(Cycle cycle);
  void request_earlier(Cycle cycle);
  void on_tick();

  std::uint64_t period_fs_;
  bool idle_skip_;
  sc_core::sc_event wake_;
  sc_core::sc_event tick_;
  Cycle cycle_ = 0;
  Cycle next_ = kNever;
  std::uint64_t ticks_ = 0;
  std::array<std::uint64_t, kWheel / 64> wheel_{};
  std::set<Cycle> far_;
};

/// Call first in sc_main and in every test fixture.
void set_time_resolution_to_fs();

}  // namespace grtx::modules
