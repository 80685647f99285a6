// A work distributor as the GPU sees it, where its ray groups come from, and who is told of each warp.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <vector>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/simt/decide/launch_order.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

/// Where ray groups come from. Positions 0..count()-1 are acquired in ascending order, each once, and released in any.
class GroupSource {
 public:
  virtual ~GroupSource() = default;
  virtual std::uint64_t count() const = 0;
  /// The group at `position`; it stays valid and unchanged until released. Throws Error if it cannot be read.
  virtual const traces::RayGroup* acquire(std::uint64_t position) = 0;
  virtual void release(std::uint64_t position) = 0;
};

/// Is told of each warp's start and end; for pictures of where the time went. Called a few times a warp.
class WarpObserver {
 public:
  virtual ~WarpObserver() = default;
  virtual void launched(unsigned sm, unsigned slot, const traces::RayGroup& group, Cycle now) = 0;
  virtual void ended(unsigned sm, unsigned slot, Cycle now) = 0;
};

/// What a distributor of work has done.
struct DistributorCounters {
  std::uint64_t groups = 0;
  std::uint64_t most_on_one_sm = 0;
  std::uint64_t fewest_on_one_sm = 0;
  Cycle tail_cycles = 0;  ///< from the last launch to the end
  std::vector<LaunchSpan> launches;
};

/// Hands the ray groups of a source to SMs with a free warp slot, each group once.
class WorkDistributorModule : public ClockedModule {
 public:
  sc_core::sc_vector<LinkOut<LaunchWarp>> launch;  ///< to each SM
  sc_core::sc_vector<LinkIn<WarpEnded>> ended;     ///< from each SM

  /// Fires in the delta cycle after the one in which the last group's end was seen.
  virtual const sc_core::sc_event& done() const = 0;
  /// Attach before the run; must outlive it. nullptr: none.
  virtual void observe(WarpObserver* observer) = 0;
  virtual bool finished() const = 0;
  /// Cycle in which the end of the last group was seen: the cycles that the GPU took. Valid once finished().
  virtual Cycle end_cycle() const = 0;
  virtual std::uint64_t launched() const = 0;
  virtual std::uint64_t running() const = 0;
  virtual bool idle() const = 0;
  virtual DistributorCounters counters() const = 0;
  virtual Inventory inventory() const = 0;
  virtual void dump_state(std::ostream& out) const = 0;

 protected:
  WorkDistributorModule(const sc_core::sc_module_name& name, ClockDomain& clock, unsigned sms)
      : ClockedModule(name, clock), launch("launch", sms), ended("ended", sms) {}
};

}  // namespace grtx::modules
