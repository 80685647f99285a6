// SPDX-License-Identifier: Apache-2.0
// Work distributor of the GPU: assigns the ray groups of a trace, in index order, to SMs with a free warp slot.
// One per GPU, in front of the SMs; the paper does not describe it (round robin is what public simulators do).
// A launch waits for the end of the previous one (launch_order.h): a frame's secondary rays for its primary rays, a
// frame for the previous frame. Cost: a credit counter per SM; not part of the GRTX hardware.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <systemc>
#include <vector>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/simt/decide/launch_order.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

/// Source of ray groups. Positions 0..count()-1 are each acquired once, in ascending order, and released in any order.
class GroupSource {
 public:
  virtual ~GroupSource() = default;
  virtual std::uint64_t count() const = 0;
  /// Returns the group at `position`, valid and unchanged until released. Throws Error if it cannot be read.
  virtual const traces::RayGroup* acquire(std::uint64_t position) = 0;
  virtual void release(std::uint64_t position) = 0;
};

/// Observer of each warp's start and end, for timeline pictures.
class WarpObserver {
 public:
  virtual ~WarpObserver() = default;
  virtual void launched(unsigned sm, unsigned slot, const traces::RayGroup& group, Cycle now) = 0;
  virtual void ended(unsigned sm, unsigned slot, Cycle now) = 0;
};

/// Counters of a work distributor.
struct DistributorCounters {
  std::uint64_t groups = 0;
  std::uint64_t most_on_one_sm = 0;
  std::uint64_t fewest_on_one_sm = 0;
  Cycle tail_cycles = 0;  ///< from the launch of the last warp to the end
  std::vector<LaunchSpan> launches;
};

/// A distributor as the GPU sees it: assigns each ray group of a source to an SM with a free warp slot.
class WorkDistributorModule : public ClockedModule {
 public:
  sc_core::sc_vector<LinkOut<LaunchWarp>> launch;  ///< [sm]
  sc_core::sc_vector<LinkIn<WarpEnded>> ended;     ///< [sm]

  /// Notified in the delta cycle after the one in which the end of the last group was seen.
  virtual const sc_core::sc_event& done() const = 0;
  /// Sets the observer, before the run; it must outlive the run. nullptr: none.
  virtual void observe(WarpObserver* observer) = 0;
  virtual bool finished() const = 0;
  /// Cycle in which the end of the last group was seen, that is, the GPU's run time. Valid once finished().
  virtual Cycle end_cycle() const = 0;
  virtual std::uint64_t launched() const = 0;
  virtual std::uint64_t running() const = 0;
  virtual bool idle() const = 0;
  virtual DistributorCounters counters() const = 0;
  virtual Inventory inventory() const = 0;
  virtual void dump_state(std::ostream& out) const = 0;

 protected:
  WorkDistributorModule(const char* name, ClockDomain& clock, unsigned sms) = delete;  ///< see ClockedModule
  WorkDistributorModule(const sc_core::sc_module_name& name, ClockDomain& clock, unsigned sms)
      : ClockedModule(name, clock), launch("launch", sms), ended("ended", sms) {}
};

struct WorkDistributorConfig {
  unsigned sms = 8;
  unsigned resident_warps = 32;  ///< warp slots of an SM, at most 64
};

/// Appends the counters as prefix + ".name".
void describe(const DistributorCounters& counters, StatisticList& list, const std::string& prefix);

class WorkDistributor final : public WorkDistributorModule {
 public:
  /// `source` must outlive the module.
  WorkDistributor(const sc_core::sc_module_name& name, ClockDomain& domain, const WorkDistributorConfig& config,
                  GroupSource& source);

  const sc_core::sc_event& done() const override { return done_; }
  void observe(WarpObserver* observer) override { observer_ = observer; }
  bool finished() const override { return finished_; }
  Cycle end_cycle() const override { return end_cycle_; }
  std::uint64_t launched() const override { return next_; }
  std::uint64_t running() const override { return running_; }
  std::uint64_t launched_on(unsigned sm) const { return sms_[sm].launched; }
  bool idle() const override { return running_ == 0; }

  DistributorCounters counters() const override;
  void statistics(StatisticList& list, const std::string& prefix) const { describe(counters(), list, prefix); }
  Inventory inventory() const override;
  void dump_state(std::ostream& out) const override;

 private:
  struct Sm {
    LinkWriter<LaunchWarp> launch;
    LinkReader<WarpEnded> ended;
    LaneMask free_slots = 0;
    std::vector<std::uint64_t> position;  ///< [slot] position of its running group
    std::uint64_t launched = 0;
  };

  void start_of_simulation() override;
  Cycle tick(Cycle now) override;
  void restart(Caches caches) override;
  void collect(Cycle now);
  void dispatch(Cycle now);
  bool held_back(Cycle now);
  void finish(Cycle now);

  WorkDistributorConfig config_;
  GroupSource& source_;
  WarpObserver* observer_ = nullptr;
  sc_core::sc_event done_;
  std::vector<Sm> sms_;
  std::uint64_t groups_;    ///< number of groups in the source
  std::uint64_t next_ = 0;  ///< next position to launch
  std::uint64_t running_ = 0;
  unsigned free_slots_;                      ///< free slots of all SMs
  unsigned turn_ = 0;                        ///< round robin: SM to try first
  const traces::RayGroup* ready_ = nullptr;  ///< acquired at next_, not launched yet
  LaunchOrder order_;
  bool finished_ = false;
  Cycle first_launch_ = 0;
  Cycle last_launch_ = 0;
  Cycle end_cycle_ = 0;
};

}  // namespace grtx::modules
