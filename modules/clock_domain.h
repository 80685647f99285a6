// A clock domain: edges on an integer grid of time, no free-running clock. It ticks in the cycles that somebody asked
// for, and in each of them wakes only the processes whose alarm is due.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <set>
#include <systemc>
#include <utility>
#include <vector>

#include "base/strong.h"

namespace grtx::modules {

inline constexpr Cycle kNever = std::numeric_limits<Cycle>::max();

class Alarm;

/// Clocked modules own an Alarm and make one SC_METHOD statically sensitive to it with dont_initialize(). Observers
/// that want to see every cycle in which anything happens are sensitive to `tick()` instead. The domain jumps from one
/// requested cycle to the next; while modules are busy that is one kernel notification a cycle. Times are integers of
/// the kernel's resolution (1 fs, set before elaboration): no floating-point time accumulates.
class ClockDomain final : public sc_core::sc_module {
 public:
  SC_HAS_PROCESS(ClockDomain);
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
  /// Of a clock of that frequency, as every domain rounds it.
  static std::uint64_t period_fs(double mhz);
  /// Asks for a tick() at `cycle` (> cycle() when called from a tick process; an earlier one is moved to cycle() + 1).
  /// May be called from outside the domain (TLM callbacks): the edge is the first one not before the present time.
  /// A request stays booked until its cycle, whatever other cycles tick before it; kNever asks for nothing.
  void request(Cycle cycle) {
    if (cycle >= next_) {
      if (cycle != next_) {
        book(cycle);
      } else {
        next_wanted_ = true;
      }
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

  friend class Alarm;
  friend class ProcessBundle;

  /// Alarms by index. Their cycles lie together: every tick looks at all cycles, but touches only what is due.
  struct AlarmList {
    std::vector<Cycle> cycles;
    std::vector<Alarm*> alarms;
    std::vector<std::pair<void (*)(void*), void*>> calls;  ///< what a bundle does for the alarm, and of which module
    Alarm* whole = nullptr;  ///< alarm of the bundle that runs them; null for the domain's own list
    bool running = false;    ///< the bundle runs them and will look at their cycles afterwards
  };

  static Cycle earliest(const AlarmList& list) {
    Cycle earliest = kNever;
    for (const Cycle cycle : list.cycles) earliest = std::min(earliest, cycle);
    return earliest;
  }
  void book(Cycle cycle) {
    if (cycle - cycle_ < kWheel) {
      std::uint64_t& word = wheel_[(cycle % kWheel) / 64];
      const std::uint64_t bit = std::uint64_t{1} << (cycle % 64);
      booked_ += (word & bit) == 0 ? 1 : 0;
      word |= bit;
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
  mutable bool observed_ = false;  ///< somebody has asked for tick_
  Cycle cycle_ = 0;
  Cycle next_ = kNever;
  bool next_wanted_ = false;  ///< somebody asked for next_ since the present tick began
  std::uint64_t ticks_ = 0;
  unsigned booked_ = 0;  ///< cycles in the wheel
  std::array<std::uint64_t, kWheel / 64> wheel_{};
  std::set<Cycle> far_;
  AlarmList alarms_;
  AlarmList* building_ = &alarms_;  ///< where new alarms go
};

/// The wake-up call of one clocked process. It keeps the earliest request only: a process that runs asks again for what
/// is left to do, arrivals on its links included (Link::wake() asks for them when they are sent).
class Alarm {
 public:
  using Call = void (*)(void* module);

  explicit Alarm(ClockDomain& domain) : Alarm(domain, domain.alarms_, nullptr, nullptr) {}
  /// The same for a process that a bundle may run: run(module) does what the process does.
  Alarm(ClockDomain& domain, void* module, Call run) : Alarm(domain, *domain.building_, module, run) {}
  /// The same for a module that needs no process: that of the domain calls run(module).
  static Alarm without_process(ClockDomain& domain, void* module, Call run) {
    return Alarm(domain, domain.alarms_, module, run, true);
  }
  Alarm(const Alarm&) = delete;
  Alarm& operator=(const Alarm&) = delete;

  const sc_core::sc_event& event() const { return event_; }
  /// The process runs at `cycle`, or before. kNever asks for nothing. A past cycle is the next one.
  void request(Cycle cycle) {
    if (cycle < list_.cycles[index_]) set(cycle);
  }

 private:
  friend class ClockDomain;
  friend class ProcessBundle;

  Alarm(ClockDomain& domain, ClockDomain::AlarmList& list, void* module, Call run, bool called = false)
      : domain_(domain), list_(list), index_(list.cycles.size()), called_(called) {
    list.cycles.push_back(kNever);
    list.alarms.push_back(this);
    list.calls.emplace_back(run, module);
  }
  void set(Cycle cycle) {
    if (cycle <= domain_.cycle_ && domain_.ticks_ > 0) cycle = domain_.cycle_ + 1;  // an edge fires once
    list_.cycles[index_] = cycle;
    if (list_.running) return;
    if (list_.whole != nullptr) return list_.whole->request(cycle);
    if (cycle < domain_.next_) domain_.schedule(cycle);
  }

  ClockDomain& domain_;
  ClockDomain::AlarmList& list_;
  std::size_t index_;
  bool called_;  ///< the domain calls it, no process waits for the event
  sc_core::sc_event event_;
};

/// Runs the processes of several modules in that of the clock domain: an activation by the kernel costs as much as the
/// work of a small module in a cycle. A member of the module that assembles them. Modules built between begin() and
/// end() join; their own processes then sleep. Results do not depend on it, since modules meet through registered links
/// only.
class ProcessBundle {
 public:
  explicit ProcessBundle(ClockDomain& domain)
      : domain_(domain),
        whole_(
            domain, domain.alarms_, this, [](void* bundle) { static_cast<ProcessBundle*>(bundle)->run(); }, true) {
    list_.whole = &whole_;
  }
  ProcessBundle(const ProcessBundle&) = delete;
  ProcessBundle& operator=(const ProcessBundle&) = delete;

  void begin() { domain_.building_ = &list_; }
  void end() { domain_.building_ = &domain_.alarms_; }

 private:
  /// Runs the modules whose alarm is due.
  void run();

  ClockDomain& domain_;
  Alarm whole_;
  ClockDomain::AlarmList list_;
};

/// Call first in sc_main and in every test fixture.
void set_time_resolution_to_fs();

}  // namespace grtx::modules
