// SPDX-License-Identifier: Apache-2.0
// A clock domain: edges on an integer time grid, without a free-running clock. It ticks only in requested cycles, and
// in each of them calls only the modules whose alarm is due.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <set>
#include <systemc>
#include <vector>

#include "grtx/base/strong.h"
#include "grtx/modules/kernel/run_ahead.h"

namespace grtx::modules {

using grtx::kNever;

class Alarm;

/// Contents of caches and open DRAM rows when a launch begins.
enum class Caches : std::uint8_t {
  cold,  ///< empty, closed
  warm,  ///< as the previous launch left them
};

/// The interface through which a clock domain calls a module, the same in unit tests, in the GPU and on other
/// platforms.
class Clocked {
 public:
  /// Does the work of cycle `now`. Returns the next cycle with work, including items already on the input links (their
  /// next_visible()). kNever: no work until something new is sent, which sets the alarm by itself. A value <= now means
  /// the next cycle. A tick in which nothing is due must change nothing.
  virtual Cycle tick(Cycle now) = 0;
  /// Prepares for another launch, which counts cycles from 0 again: back to the constructed state with zero counters.
  /// Usually the unit is empty. After a launch that stood still it is not: it drops what it holds.
  virtual void restart(Caches /*caches*/) {}

 protected:
  ~Clocked() = default;
};

/// An object that restarts with a clock domain but is not called by it, such as a link. Alarm::restarts() registers it.
class Restarted {
 public:
  /// For another launch: back to the constructed state.
  virtual void restart() = 0;

 protected:
  ~Restarted() = default;
};

/// Modules own an Alarm each; observers that need every active cycle are sensitive to tick() instead. The domain jumps
/// from one requested cycle to the next, with one kernel notification per cycle, or none (RunAhead). Modules
/// communicate only through registered links, so the order in which they are called within a cycle does not affect
/// results. Times are integers in the kernel's resolution, as sc_time::value() has them, so no rounding error
/// accumulates; the resolution must divide the period (1 fs divides all). Cycle 0 is at time 0, or at the last
/// restart().
class ClockDomain final : public sc_core::sc_module {
 public:
  using SC_CURRENT_USER_MODULE = ClockDomain;  // SC_HAS_PROCESS, which SystemC 3 deprecates
  /// mhz: frequency, rounded to an integer period in fs. idle_skip false ticks every cycle (for tests).
  ClockDomain(const sc_core::sc_module_name& name, double mhz, bool idle_skip = true);

  /// Fires in every cycle that the domain does not skip.
  const sc_core::sc_event& tick() const {
    observed_ = true;
    return tick_;
  }
  /// The current cycle, that is, the cycle of the last tick. Valid inside processes sensitive to tick().
  Cycle cycle() const { return cycle_; }
  std::uint64_t period_fs() const { return period_ * resolution_fs_; }
  /// The period as an sc_time's value(): in the kernel's resolution.
  std::uint64_t period_value() const { return period_; }
  /// Clock period in fs for a frequency in MHz, rounded as every domain rounds it.
  static std::uint64_t period_fs(double mhz);
  /// Requests a tick() in `cycle`. From a tick process an earlier cycle is moved to cycle() + 1; from outside the
  /// domain (TLM callbacks) a past one is moved to the first edge at or after the current time. The request stays
  /// booked until its cycle, even if earlier cycles tick before it. kNever requests nothing.
  void request(Cycle cycle) {
    if (cycle < next_) return request_earlier(cycle);
    book(cycle);
  }
  /// Current time: the kernel's, or that of the last tick if the domain runs ahead of the kernel.
  std::uint64_t now_value() const {
    const std::uint64_t kernel = kernel_value();
    return ahead_ == nullptr ? kernel : std::max(kernel, ahead_->now_value_);
  }
  std::uint64_t now_fs() const { return now_value() * resolution_fs_; }
  /// now_value() + delay_value relative to the kernel's time: the delay to annotate in a TLM call.
  sc_core::sc_time ahead_of_kernel(std::uint64_t delay_value = 0) const {
    return sc_core::sc_time::from_value(now_value() - kernel_value() + delay_value);
  }
  /// First edge at or after now_value(), for callers outside the domain.
  Cycle edge_at_or_after_now() const { return (now_value() - begin_ + period_ - 1) / period_; }
  /// First edge strictly after the kernel's time + delay_value: the cycle in which a TLM call with this annotated delay
  /// becomes visible. Strictly, so that the order of caller and domain does not matter if both have an edge now.
  Cycle edge_after(std::uint64_t delay_value = 0) const {
    return (kernel_value() - begin_ + delay_value) / period_ + 1;
  }
  /// Time of the edge of `cycle`.
  std::uint64_t time_value(Cycle cycle) const { return begin_ + cycle * period_; }
  std::uint64_t time_fs(Cycle cycle) const { return time_value(cycle) * resolution_fs_; }
  /// Cycle that contains `time_fs`; 0 for times before cycle 0.
  Cycle cycle_at(std::uint64_t time_fs) const {
    const std::uint64_t time = time_fs / resolution_fs_;
    return time <= begin_ ? 0 : (time - begin_) / period_;
  }
  /// Prepares for another launch: cycle 0 is now, nothing is booked, and restart() is called on all modules and on the
  /// links that lead to them.
  void restart(Caches caches);
  std::uint64_t ticks() const { return ticks_; }  ///< cycles that were not skipped
  /// The latest cycle for which an alarm is set; 0 if none is. Linear in the number of modules; for watchdogs.
  Cycle latest() const;
  /// Allows this domain and the other one of its RunAhead to run ahead of the kernel, to before time `until_value`.
  void allow_ahead(std::uint64_t until_value);

 private:
  friend class Alarm;
  friend class RunAhead;

  // Timing wheel over the next 64 cycles with one bit per alarm. The few alarms and bookings farther away wait in far_
  // and far_booked_ and enter the wheel when they come within its range.
  static constexpr Cycle kWheel = 64;
  static constexpr std::uint64_t bit_of(std::uint64_t i) { return std::uint64_t{1} << i % 64; }
  struct Wheel {
    std::array<std::uint64_t, kWheel> at{};  ///< [cycle % kWheel]: bit mask of the alarms due
  };
  std::uint64_t kernel_value() const {
    return ahead_ != nullptr && ahead_->running_ ? ahead_->kernel_value_ : sc_core::sc_time_stamp().value();
  }
  std::size_t add(Clocked& clocked);
  void set(std::size_t alarm, Cycle cycle);
  void forget(std::size_t alarm);
  void place(std::size_t alarm, Cycle cycle) {
    if (cycle - cycle_ >= kWheel) return place_far(alarm, cycle);
    due_[alarm / 64].at[cycle % kWheel] |= bit_of(alarm);
    busy_ |= bit_of(cycle);
  }
  void place_far(std::size_t alarm, Cycle cycle);
  void book(Cycle cycle) {
    if (cycle - cycle_ < kWheel) {
      booked_ |= bit_of(cycle);
    } else if (cycle != kNever) {
      far_booked_.insert(cycle);
    }
  }
  void bring_near();
  Cycle earliest() const;
  void schedule(Cycle cycle);
  void notify_kernel();
  void request_earlier(Cycle cycle);
  void run_alarm(std::size_t alarm);
  Cycle ticked(Clocked& clocked, Cycle now) const;
  void on_wake();
  void step();

  std::uint64_t resolution_fs_;  ///< of the kernel's time
  std::uint64_t period_;         ///< in it, as the next
  std::uint64_t begin_ = 0;      ///< time of cycle 0
  bool idle_skip_;
  sc_core::sc_event wake_;
  sc_core::sc_event tick_;
  mutable bool observed_ = false;  ///< tick() has been called
  RunAhead* ahead_ = nullptr;
  Cycle cycle_ = 0;
  Cycle next_ = kNever;
  bool next_wanted_ = false;  ///< the next cycle must tick
  std::uint64_t ticks_ = 0;

  std::vector<Clocked*> alarms_;
  std::vector<Restarted*> restarted_;
  std::vector<Cycle> wanted_;       ///< [alarm] cycle it is set to; kNever if not set
  Cycle soonest_ = 0;               ///< first cycle that has not ticked: the earliest that an alarm can be set to
  std::vector<Wheel> due_;          ///< [alarm / 64]
  std::uint64_t busy_ = 0;          ///< wheel slots with an alarm
  std::uint64_t booked_ = 0;        ///< wheel slots booked by request()
  std::vector<std::uint64_t> far_;  ///< [alarm / 64] alarms that were beyond the wheel when set
  Cycle far_from_ = kNever;         ///< lower bound of the cycles of far_
  std::set<Cycle> far_booked_;
};

/// The wake-up call of a clocked module. It keeps only the earliest request: tick() returns the next one, and links set
/// the alarm when something is sent.
class Alarm {
 public:
  Alarm(ClockDomain& domain, Clocked& clocked) : domain_(domain), index_(domain.add(clocked)) {}
  Alarm(const Alarm&) = delete;
  Alarm& operator=(const Alarm&) = delete;

  /// Ensures that tick() is called in `cycle` or earlier. kNever requests nothing; a past cycle means the next one.
  void request(Cycle cycle) {
    if (cycle < domain_.wanted_[index_]) domain_.set(index_, cycle);
  }
  /// `thing` restarts with the domain, before its modules. Must live as long.
  void restarts(Restarted& thing) { domain_.restarted_.push_back(&thing); }

 private:
  ClockDomain& domain_;
  std::size_t index_;
};

/// Before anything else of SystemC, unless the platform has a resolution that divides the periods of its clocks. Throws
/// Error if another one is already fixed.
void set_time_resolution_to_fs();

}  // namespace grtx::modules
