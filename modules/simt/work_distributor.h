// SPDX-License-Identifier: Apache-2.0
// Work distributor of the GPU: assigns the ray groups of a trace, in index order, to SMs with a free warp slot.
// One per GPU, in front of the SMs; the paper does not describe it. Which SM a policy says (work_distribution.h).
// A launch waits for the end of the previous one (launch_order.h): a frame's secondary rays for its primary rays, a
// frame for the previous frame. Cost: a credit counter per SM; not part of the GRTX hardware.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <string>
#include <systemc>
#include <vector>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/simt/decide/launch_order.h"
#include "grtx/modules/simt/decide/work_distribution.h"
#include "grtx/modules/simt/work_distributor_if.h"

namespace grtx::modules {

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
  unsigned chosen_sm() const;
  bool held_back(Cycle now);
  void finish(Cycle now);

  WorkDistributorConfig config_;
  GroupSource& source_;
  WarpObserver* observer_ = nullptr;
  sc_core::sc_event done_;
  std::vector<Sm> sms_;
  std::unique_ptr<WorkDistribution> distribution_;
  std::vector<unsigned> room_;  ///< [sm] what the policy is told
  std::uint64_t groups_;        ///< number of groups in the source
  std::uint64_t next_ = 0;      ///< next position to launch
  std::uint64_t running_ = 0;
  unsigned free_slots_;                      ///< free slots of all SMs
  const traces::RayGroup* ready_ = nullptr;  ///< acquired at next_, not launched yet
  LaunchOrder order_;
  bool finished_ = false;
  Cycle first_launch_ = 0;
  Cycle last_launch_ = 0;
  Cycle end_cycle_ = 0;
};

}  // namespace grtx::modules
