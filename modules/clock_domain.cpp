#include "modules/clock_domain.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

namespace grtx::modules {

void set_time_resolution_to_fs() { sc_core::sc_set_time_resolution(1, sc_core::SC_FS); }

ClockDomain::ClockDomain(const sc_core::sc_module_name& name, double mhz, bool idle_skip)
    : sc_module(name), period_fs_(period_fs(mhz)), idle_skip_(idle_skip) {
  assert(mhz > 0.0);
  SC_METHOD(on_tick);
  sensitive << wake_;
  dont_initialize();
}

std::uint64_t ClockDomain::period_fs(double mhz) { return static_cast<std::uint64_t>(std::llround(1e9 / mhz)); }

Cycle ClockDomain::edge_at_or_after_now() const {
  const std::uint64_t now = sc_core::sc_time_stamp().value();
  return (now + period_fs_ - 1) / period_fs_;
}

Cycle ClockDomain::earliest_booked() const {
  if (booked_ == 0) return far_.empty() ? kNever : *far_.begin();
  // Bits of the wheel in cycle order, beginning with the cycle after the present one and wrapping once around.
  const Cycle start = cycle_ + 1;
  for (Cycle checked = 0; checked < kWheel;) {
    const Cycle cycle = start + checked;
    const std::uint64_t word = wheel_[(cycle % kWheel) / 64] >> (cycle % 64);
    if (word != 0) {
      const Cycle found = cycle + static_cast<Cycle>(std::countr_zero(word));
      return far_.empty() ? found : std::min(found, *far_.begin());
    }
    checked += 64 - cycle % 64;
  }
  return far_.empty() ? kNever : *far_.begin();
}

void ClockDomain::schedule(Cycle cycle) {
  next_ = cycle;  // earlier than what was scheduled, which the kernel then drops
  wake_.notify(sc_core::sc_time::from_value(cycle * period_fs_) - sc_core::sc_time_stamp());
}

void ClockDomain::request_earlier(Cycle cycle) {
  // An edge that has already fired cannot fire again; a past edge is the next one not before now.
  Cycle earliest = edge_at_or_after_now();
  if (ticks_ > 0 && earliest <= cycle_) earliest = cycle_ + 1;
  const Cycle target = std::max(cycle, earliest);
  book(target);
  if (target < next_) schedule(target);
}

void ClockDomain::on_tick() {
  cycle_ = next_;
  std::uint64_t& word = wheel_[(cycle_ % kWheel) / 64];
  const std::uint64_t bit = std::uint64_t{1} << (cycle_ % 64);
  if ((word & bit) != 0) {
    word &= ~bit;
    --booked_;
  }
  if (!far_.empty() && *far_.begin() == cycle_) far_.erase(far_.begin());
  next_ = cycle_ + 1;  // whatever is asked for meanwhile is not earlier
  next_wanted_ = !idle_skip_;
  ++ticks_;
  // Bundles run here, and by immediate notifications all other clocked processes in this evaluation phase.
  for (std::size_t i = 0; i < alarms_.cycles.size(); ++i) {
    if (alarms_.cycles[i] > cycle_ && idle_skip_) continue;
    alarms_.cycles[i] = kNever;
    if (alarms_.alarms[i]->called_) {
      const auto [run, bundle] = alarms_.calls[i];
      run(bundle);
      next_wanted_ |= observed_;
    } else {
      alarms_.alarms[i]->event_.notify();
      next_wanted_ = true;  // who has not run yet mostly wants the next cycle
    }
  }
  if (observed_) tick_.notify();
  const Cycle next = next_wanted_ ? cycle_ + 1 : std::min(earliest(alarms_), earliest_booked());
  next_ = kNever;
  if (next != kNever) schedule(next);
}

void ProcessBundle::run() {
  list_.running = true;
  for (std::size_t i = 0; i < list_.cycles.size(); ++i) {
    if (list_.cycles[i] > domain_.cycle_ && domain_.idle_skip_) continue;
    list_.cycles[i] = kNever;
    const auto [run, module] = list_.calls[i];
    run(module);
  }
  list_.running = false;
  if (const Cycle due = ClockDomain::earliest(list_); due != kNever) whole_.request(due);
}

}  // namespace grtx::modules
