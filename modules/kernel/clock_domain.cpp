// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/kernel/clock_domain.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>
#include <utility>

#include "grtx/base/error.h"
#include "grtx/modules/kernel/unit_fault.h"

namespace grtx::modules {

namespace {

/// The kernel's resolution, which reading also fixes; 0 if it is finer than 1 fs.
std::uint64_t resolution_fs() {
  return static_cast<std::uint64_t>(std::llround(sc_core::sc_get_time_resolution().to_seconds() * 1e15));
}

/// Throws Error if a clock's edges do not lie on the kernel's grid, and names the nearest frequency whose edges do.
void check_resolution(const std::string& name, double mhz, std::uint64_t resolution_fs) {
  const std::uint64_t period = ClockDomain::period_fs(mhz);
  // Half a period, too, has a place there: observers look between two edges.
  if (resolution_fs != 0 && period % resolution_fs == 0 && period >= 2 * resolution_fs) return;
  std::string other;
  if (resolution_fs != 0) {
    const std::uint64_t nearest = std::max<std::uint64_t>(2, (period + resolution_fs / 2) / resolution_fs);
    other = fmt::format(", or choose {:.10g} MHz", 1e9 / static_cast<double>(nearest * resolution_fs));
  }
  throw Error("SystemC kernel", "clock domain " + name,
              fmt::format("the period of {:.10g} MHz, {} fs, is no multiple of the time resolution, {}: call "
                          "set_time_resolution_to_fs() before anything else of SystemC{}",
                          mhz, period, sc_core::sc_get_time_resolution().to_string(), other));
}

}  // namespace

void set_time_resolution_to_fs() {
  try {
    sc_core::sc_set_time_resolution(1, sc_core::SC_FS);
  } catch (const sc_core::sc_report& report) {
    if (resolution_fs() == 1) return;  // already set
    throw Error(
        "SystemC kernel", "time resolution",
        "is " + sc_core::sc_get_time_resolution().to_string() +
            " and can no longer become 1 fs: call set_time_resolution_to_fs() before anything else of SystemC (" +
            report.get_msg() + ")");
  }
}

ClockDomain::ClockDomain(const sc_core::sc_module_name& name, double mhz, bool idle_skip)
    : sc_module(name), resolution_fs_(resolution_fs()), idle_skip_(idle_skip) {
  assert(mhz > 0.0);
  check_resolution(this->name(), mhz, resolution_fs_);
  period_ = period_fs(mhz) / resolution_fs_;
  SC_METHOD(on_wake);
  sensitive << wake_;
  dont_initialize();
}

std::uint64_t ClockDomain::period_fs(double mhz) { return static_cast<std::uint64_t>(std::llround(1e9 / mhz)); }

void ClockDomain::allow_ahead(std::uint64_t until_value) {
  if (ahead_ != nullptr) ahead_->until_value_ = until_value;
}

std::size_t ClockDomain::add(Clocked& clocked) {
  const std::size_t index = alarms_.size();
  alarms_.push_back(&clocked);
  wanted_.push_back(kNever);
  if (index / 64 == due_.size()) {
    due_.emplace_back();
    far_.push_back(0);
  }
  return index;
}

void ClockDomain::place_far(std::size_t alarm, Cycle cycle) {
  far_[alarm / 64] |= bit_of(alarm);
  far_from_ = std::min(far_from_, cycle);
}

void ClockDomain::forget(std::size_t alarm) {
  std::uint64_t& far = far_[alarm / 64];
  if ((far & bit_of(alarm)) != 0) {
    far &= ~bit_of(alarm);
    return;
  }
  const Cycle cycle = wanted_[alarm];
  due_[alarm / 64].at[cycle % kWheel] &= ~bit_of(alarm);
  std::uint64_t left = 0;
  for (const Wheel& wheel : due_) left |= wheel.at[cycle % kWheel];
  if (left == 0) busy_ &= ~bit_of(cycle);
}

void ClockDomain::set(std::size_t alarm, Cycle cycle) {
  cycle = std::max(cycle, soonest_);
  if (wanted_[alarm] != kNever) forget(alarm);
  wanted_[alarm] = cycle;
  place(alarm, cycle);
  if (cycle < next_) schedule(cycle);
}

// Moves alarms and bookings that are now within the wheel's range into the wheel.
void ClockDomain::bring_near() {
  while (!far_booked_.empty() && *far_booked_.begin() - cycle_ < kWheel) {
    booked_ |= bit_of(*far_booked_.begin());
    far_booked_.erase(far_booked_.begin());
  }
  if (far_from_ >= cycle_ + kWheel) return;
  far_from_ = kNever;
  for (std::size_t word = 0; word < far_.size(); ++word) {
    for (std::uint64_t rest = std::exchange(far_[word], 0); rest != 0; rest &= rest - 1) {
      const std::size_t alarm = word * 64 + static_cast<std::size_t>(std::countr_zero(rest));
      place(alarm, wanted_[alarm]);
    }
  }
}

// The earliest alarm or booking after cycle_. Nothing beyond the wheel is earlier than what is in it.
Cycle ClockDomain::earliest() const {
  const std::uint64_t near = busy_ | booked_;
  if (near != 0) {
    const int distance = std::countr_zero(std::rotr(near, static_cast<int>((cycle_ + 1) % kWheel)));
    return cycle_ + 1 + static_cast<Cycle>(distance);
  }
  Cycle earliest = far_booked_.empty() ? kNever : *far_booked_.begin();
  for (std::size_t word = 0; word < far_.size(); ++word) {
    for (std::uint64_t rest = far_[word]; rest != 0; rest &= rest - 1) {
      earliest = std::min(earliest, wanted_[word * 64 + static_cast<std::size_t>(std::countr_zero(rest))]);
    }
  }
  return earliest;
}

Cycle ClockDomain::latest() const {
  Cycle latest = far_booked_.empty() ? 0 : *far_booked_.rbegin();
  for (const Cycle wanted : wanted_) {
    if (wanted != kNever) latest = std::max(latest, wanted);
  }
  return latest;
}

void ClockDomain::schedule(Cycle cycle) {
  next_ = cycle;  // earlier than the pending notification, which the kernel then discards
  if (ahead_ == nullptr || !ahead_->running_) notify_kernel();
}

void ClockDomain::notify_kernel() {
  wake_.notify(sc_core::sc_time::from_value(time_value(next_)) - sc_core::sc_time_stamp());
}

void ClockDomain::restart(Caches caches) {
  assert(ahead_ == nullptr || !ahead_->running_);
  wake_.cancel();
  begin_ = now_value();
  cycle_ = soonest_ = ticks_ = 0;
  next_ = kNever;
  std::fill(wanted_.begin(), wanted_.end(), kNever);
  std::fill(due_.begin(), due_.end(), Wheel{});
  std::fill(far_.begin(), far_.end(), 0);
  busy_ = booked_ = 0;
  far_from_ = kNever;
  far_booked_.clear();
  for (Restarted* thing : restarted_) thing->restart();
  for (Clocked* clocked : alarms_) clocked->restart(caches);
}

void ClockDomain::request_earlier(Cycle cycle) {
  // An edge that has ticked cannot tick again; a past cycle becomes the first edge at or after now.
  const Cycle earliest = edge_at_or_after_now();
  const Cycle target = std::max({cycle, earliest, soonest_});
  book(target);
  if (target < next_) schedule(target);
}

void ClockDomain::on_wake() {
  step();
  if (next_ != kNever && (ahead_ == nullptr || !ahead_->run())) notify_kernel();
}

// A wrong answer that nobody has blamed on a part is the module's.
inline Cycle ClockDomain::ticked(Clocked& clocked, Cycle now) const {
  try {
    return clocked.tick(now);
  } catch (const WrongAnswer& answer) {
    const auto* const module = dynamic_cast<const sc_core::sc_object*>(&clocked);
    unit_fault(module == nullptr ? name() : module->name(), answer.what());
  } catch (const Error& error) {
    SC_REPORT_ERROR(kInputReport, error.what());
    throw;  // if reports are configured not to throw
  }
}

void ClockDomain::run_alarm(std::size_t alarm) {
  wanted_[alarm] = kNever;
  const Cycle next = ticked(*alarms_[alarm], cycle_);
  if (next < wanted_[alarm]) set(alarm, next);
  next_wanted_ |= observed_;
}

// One cycle: calls all modules that are due, in the evaluation phase of the domain's process.
void ClockDomain::step() {
  cycle_ = next_;
  soonest_ = cycle_ + 1;
  if (!far_booked_.empty() || far_from_ < cycle_ + kWheel) bring_near();
  const std::size_t slot = cycle_ % kWheel;
  busy_ &= ~bit_of(slot);
  booked_ &= ~bit_of(slot);
  next_ = cycle_ + 1;  // requests made during this cycle cannot be earlier
  next_wanted_ = !idle_skip_;
  ++ticks_;
  if (!idle_skip_) {
    for (std::size_t alarm = 0; alarm < alarms_.size(); ++alarm) {
      if (wanted_[alarm] != kNever) forget(alarm);
      run_alarm(alarm);
    }
  } else {
    const Cycle now = cycle_;
    const Cycle soonest = soonest_;
    for (std::size_t word = 0; word < due_.size(); ++word) {
      std::uint64_t rest = std::exchange(due_[word].at[slot], 0);
      if (rest == 0) continue;
      Clocked* const* const clocked = &alarms_[word * 64];
      Cycle* const wanted = &wanted_[word * 64];
      std::uint64_t next_cycle = 0;  // alarms for the next cycle, the usual case: entered into the wheel together
      for (; rest != 0; rest &= rest - 1) {
        const auto i = static_cast<std::size_t>(std::countr_zero(rest));
        wanted[i] = kNever;
        const Cycle next = ticked(*clocked[i], now);
        if (next <= soonest && wanted[i] == kNever) {
          wanted[i] = soonest;
          next_cycle |= rest & -rest;
        } else if (next < wanted[i]) {
          set(word * 64 + i, next);
        }
      }
      next_wanted_ |= observed_;
      if (next_cycle == 0) continue;
      due_[word].at[soonest % kWheel] |= next_cycle;
      busy_ |= bit_of(soonest);
    }
  }
  if (observed_) tick_.notify();
  next_ = next_wanted_ ? cycle_ + 1 : earliest();
}

}  // namespace grtx::modules
