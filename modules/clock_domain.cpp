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
  wheel_[(cycle_ % kWheel) / 64] &= ~(std::uint64_t{1} << (cycle_ % 64));
  if (!far_.empty() && *far_.begin() == cycle_) far_.erase(far_.begin());
  next_ = cycle_ + 1;  // whatever is asked for meanwhile is not earlier
  ++ticks_;
  // Bundles run here, and by immediate notifications all other clocked processes in this evaluation phase.
  Cycle next = kNever;
  bool woke = !idle_skip_;
  for (std::size_t i = 0; i < alarms_.cycles.size(); ++i) {
    const Cycle cycle = alarms_.cycles[i];
    if (cycle > cycle_ && idle_skip_) {
      next = std::min(next, cycle);
      continue;
    }
    alarms_.cycles[i] = kNever;
    if (alarms_.alarms[i]->called_) {
      const auto [run, bundle] = alarms_.calls[i];
      run(bundle);
    } else {
      alarms_.alarms[i]->event_.notify();
    }
    woke = true;
  }
  if (observed_) tick_.notify();
  // Who woke mostly wants the next cycle too; when nobody does, one empty tick finds the way.
  next_ = kNever;
  next = woke ? cycle_ + 1 : std::min(next, earliest_booked());
  if (next != kNever) schedule(next);
}

void ProcessBundle::run() {
  for (std::size_t i = 0; i < list_.cycles.size(); ++i) {
    if (list_.cycles[i] > domain_.cycle_ && domain_.idle_skip_) continue;
    list_.cycles[i] = kNever;
    const auto [run, module] = list_.calls[i];
    run(module);
  }
  whole_.request(next());  // what ran has asked for its next cycle; this is for what did not
}

Cycle ProcessBundle::next() const {
  Cycle next = kNever;
  for (const Cycle cycle : list_.cycles) next = std::min(next, cycle);
  return next;
}

}  // namespace grtx::modules
