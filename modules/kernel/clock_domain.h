// A clock domain: edges on an integer grid of time, no free-running clock. It ticks in the cycles that somebody asked
// for, and in each of them wakes only the processes whose alarm is due.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <set>
#include <systemc>
#include <vector>

#include "grtx/base/strong.h"
#include "grtx/modules/kernel/run_ahead.h"

namespace grtx::modules {

inline constexpr Cycle kNever = std::numeric_limits<Cycle>::max();

class Alarm;
class ClockThreads;

/// What caches and open DRAM rows hold when a launch begins.
enum class Caches : std::uint8_t {
  cold,  ///< nothing
  warm,  ///< what the launch before has left
};

/// What a clock domain calls, always in the same way: in unit tests, in the whole GPU and on a foreign platform.
class Clocked {
 public:
  /// The present cycle's work. Returns the next cycle in which there is work, what is on its way on the input links
  /// (next_visible()) included; kNever: none before something is sent from now on, which sets the alarm by itself. The
  /// present cycle, or a past one, means the next cycle. Ticks in which nothing is due must change nothing.
  virtual Cycle tick(Cycle now) = 0;
  /// Another launch follows, with cycles counted from 0 again: back to the state as built, nothing counted. Called when
  /// nothing is inside, alarms being unset.
  virtual void restart(Caches /*caches*/) {}

 protected:
  ~Clocked() = default;
};

/// Clocked objects own an Alarm. Observers that want to see every cycle in which anything happens are sensitive to
/// `tick()` instead. The domain jumps from one requested cycle to the next; while modules are busy that is one kernel
/// notification a cycle, or none (RunAhead). Modules meet through registered links only, so the order in which a cycle
/// calls them changes no result.
/// Times are integers of the kernel's resolution (1 fs, set before elaboration): no floating-point time accumulates.
/// Cycle 0 is at time 0, or at the last restart().
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
  /// Index of the current cycle (of the last tick that fired). Valid inside processes sensitive to tick().
  Cycle cycle() const { return cycle_; }
  std::uint64_t period_fs() const { return period_fs_; }
  /// Period of a clock of that frequency, as every domain rounds it.
  static std::uint64_t period_fs(double mhz);
  /// Asks for a tick() at `cycle` (> cycle() when called from a tick process; an earlier one is moved to cycle() + 1).
  /// May be called from outside the domain (TLM callbacks): the edge is the first one not before the present time.
  /// A request stays booked until its cycle, whatever other cycles tick before it; kNever asks for nothing.
  void request(Cycle cycle) {
    if (cycle < next_) return request_earlier(cycle);
    book(cycle);
  }
  /// The present: the kernel's time, or that of the last tick where the domain runs ahead of the kernel.
  std::uint64_t now_fs() const {
    const std::uint64_t kernel = kernel_fs();
    return ahead_ == nullptr ? kernel : std::max(kernel, ahead_->now_fs_);
  }
  /// How far a time `delay_fs` after that is ahead of the kernel: the delay to annotate in a TLM call.
  sc_core::sc_time ahead_of_kernel(std::uint64_t delay_fs = 0) const {
    return sc_core::sc_time::from_value(now_fs() - kernel_fs() + delay_fs);
  }
  /// First edge at or after the present, for callers outside the domain.
  Cycle edge_at_or_after_now() const { return (now_fs() - begin_fs_ + period_fs_ - 1) / period_fs_; }
  /// First edge strictly after the kernel's time + delay_fs: what a TLM call that annotates this delay becomes visible
  /// at. Strict, so that it does not matter whether the caller or this domain runs first when both have an edge now.
  Cycle edge_after(std::uint64_t delay_fs = 0) const { return (kernel_fs() - begin_fs_ + delay_fs) / period_fs_ + 1; }
  /// Time of the edge.
  std::uint64_t time_fs(Cycle cycle) const { return begin_fs_ + cycle * period_fs_; }
  /// Cycle in which that time lies; 0 before cycle 0.
  Cycle cycle_at(std::uint64_t time_fs) const { return time_fs <= begin_fs_ ? 0 : (time_fs - begin_fs_) / period_fs_; }
  /// Begins anew, for another launch: cycle 0 is now, nothing is booked, and all units are as built.
  void restart(Caches caches);
  std::uint64_t ticks() const { return ticks_; }  ///< ticks that fired (cycles not skipped)
  /// The last cycle that anybody waits for, as far as is known now; 0: nobody waits. Linear: for watchdogs.
  Cycle latest() const;
  /// Lets this domain and those it shares a RunAhead with run ahead of the kernel, to before this time.
  void allow_ahead(std::uint64_t until_fs);

 private:
  friend class Alarm;
  friend class ClockThreads;
  friend class RunAhead;

  // What the next cycles have to do: a bit for each alarm in a wheel of cycles. The few alarms and bookings that are
  // farther away are looked at again when they come within reach.
  static constexpr Cycle kWheel = 64;
  static constexpr std::uint64_t bit_of(std::uint64_t i) { return std::uint64_t{1} << i % 64; }
  struct Wheel {
    std::array<std::uint64_t, kWheel> at{};  ///< [cycle modulo kWheel]: alarms that are due
  };
  std::uint64_t kernel_fs() const {
    return ahead_ != nullptr && ahead_->running_ ? ahead_->kernel_fs_ : sc_core::sc_time_stamp().value();
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
  void advance(Cycle cycle);
  void stay_awake();
  void run_alarm(std::size_t alarm);
  void on_wake();
  void step();

  std::uint64_t period_fs_;
  std::uint64_t begin_fs_ = 0;  ///< time of cycle 0
  bool idle_skip_;
  sc_core::sc_event wake_;
  sc_core::sc_event tick_;
  mutable bool observed_ = false;  ///< somebody has asked for tick_
  RunAhead* ahead_ = nullptr;
  ClockThreads* threads_ = nullptr;  ///< that follow this domain
  bool followed_ = false;            ///< a thread of ClockThreads ticks this domain, not the kernel
  Cycle cycle_ = 0;
  Cycle next_ = kNever;
  bool next_wanted_ = false;  ///< something needs the cycle after the present one
  std::uint64_t ticks_ = 0;

  std::vector<Clocked*> alarms_;
  std::vector<Cycle> wanted_;       ///< by alarm; kNever: not set
  Cycle soonest_ = 0;               ///< the first cycle that has not ticked: no alarm can be set for an earlier one
  std::vector<Wheel> due_;          ///< by 64 alarms
  std::uint64_t busy_ = 0;          ///< cycles of the wheel with an alarm
  std::uint64_t booked_ = 0;        ///< cycles of the wheel that were asked for by request()
  std::vector<std::uint64_t> far_;  ///< by 64 alarms: those beyond the wheel when they were set
  Cycle far_from_ = kNever;         ///< none of them is due before
  std::set<Cycle> far_booked_;
};

/// The wake-up call of a clocked object. It keeps the earliest request only: tick() says again what is left to do, and
/// links set it when something is sent.
class Alarm {
 public:
  Alarm(ClockDomain& domain, Clocked& clocked) : domain_(domain), index_(domain.add(clocked)) {}
  Alarm(const Alarm&) = delete;
  Alarm& operator=(const Alarm&) = delete;

  /// tick() is called in `cycle`, or before. kNever asks for nothing. A past cycle is the next one.
  void request(Cycle cycle) {
    if (cycle < domain_.wanted_[index_]) domain_.set(index_, cycle);
  }

 private:
  ClockDomain& domain_;
  std::size_t index_;
};

/// Call first in sc_main and in every test fixture.
void set_time_resolution_to_fs();

}  // namespace grtx::modules
