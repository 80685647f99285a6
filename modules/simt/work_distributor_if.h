// SPDX-License-Identifier: Apache-2.0
// The work distributor as the GPU sees it: its ports, its source of ray groups, its observer, and how to make one
// (work_distributor.h).
#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <systemc>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/simt/decide/work_distributor_config.h"
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

/// The project's distributor. `source` must outlive it.
std::unique_ptr<WorkDistributorModule> make_work_distributor(const sc_core::sc_module_name& name, ClockDomain& domain,
                                                             const WorkDistributorConfig& config, GroupSource& source);

}  // namespace grtx::modules
