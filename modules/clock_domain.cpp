#include "modules/clock_domain.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace grtx::modules {

void set_time_resolution_to_fs() { sc_core::sc_set_time_resolution(1, sc_core::SC_FS); }

ClockDomain::ClockDomain(const sc_core::sc_module_name& name, double mhz, bool idle_skip)
    : sc_module(name), period_fs_(static_cast<std::uint64_t>(std::llround(1e9 / mhz))), idle_skip_(idle_skip) {
  assert(mhz > 0.0);
  SC_METHOD(on_tick);
  sensitive << wake_;
  dont_initialize();
}

Cycle ClockDomain::edge_at_or_after_now() const {
  const std::uint64_t now = sc_core::sc_time_stamp().value();
  return (now + period_fs_ - 1) / period_fs_;
}

void ClockDomain::request_earlier(Cycle cycle) {
  // An edge that has already fired cannot fire again; a past edge is the next one not before now.
  Cycle earliest = edge_at_or_after_now();
  if (ticks_ > 0 && earliest <= cycle_) earliest = cycle_ + 1;
  const Cycle target = std::max(cycle, earliest);
  if (target >= next_) return;
  next_ = target;
  wake_.cancel();
  wake_.notify(sc_core::sc_time::from_value(target * period_fs_) - sc_core::sc_time_stamp());
}

void ClockDomain::on_tick() {
  cycle_ = next_;
  next_ = kNever;
  ++ticks_;
  if (!idle_skip_) request(cycle_ + 1);
  tick_.notify();  // immediate: all clocked processes run in this evaluation phase
}

}  // namespace grtx::modules
