// SPDX-License-Identifier: Apache-2.0
// The base of the project's schedulers: the selection of a warp by a policy, why no warp is scheduled, the
// answers of the any-hit part, and the neighbours. Cost: an age matrix.
#pragma once

#include <cstdint>
#include <memory>
#include <systemc>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/rt_unit/scheduler/decide/rt_scheduler_config.h"
#include "grtx/modules/rt_unit/scheduler/decide/warp_selection.h"
#include "grtx/modules/rt_unit/scheduler/rt_scheduler_if.h"
#include "grtx/modules/rt_unit/warp_buffer/warp_table.h"

namespace grtx::modules {

/// The work of one of the project's schedulers in a cycle, for observers.
class RtSchedulerState {
 public:
  /// Stall reason of the current state, which idle cycles are counted under.
  virtual Stall stall_reason() const = 0;
  virtual RtSchedulerCounters counters() const = 0;

 protected:
  ~RtSchedulerState() = default;
};

class SchedulerBase : public RtSchedulerModule, public RtSchedulerState, public SelectableWarps {
 public:
  std::uint64_t selections() const final { return counters_.selections; }
  void count_idle(Cycle cycles) final { counters_.stall[static_cast<std::size_t>(stall_reason())] += cycles; }
  Stall stall_reason() const final {
    if (buffer_->empty()) return Stall::empty;
    if (buffer_->ready_entries() != 0) return Stall::queue_full;
    return stall_of(buffer_->oldest_warp().wait());
  }
  RtSchedulerCounters counters() const final { return counters_; }
  bool idle() const override { return true; }  // no lanes of its own: they wait in the warp buffer
  std::uint64_t progress() const override { return counters_.selections; }
  void restart() override;

 protected:
  /// entries: warps of the warp buffer. boxes: primitive leaves are boxes.
  SchedulerBase(const sc_core::sc_module_name& name, const RtSchedulerConfig& config, unsigned entries, bool boxes);

  void end_of_elaboration() override;
  /// The entry of the warp whose lanes the any-hit part has finished. Throws Error if they were not at the shader.
  unsigned entry_of_answer(const AnyHitDone& done) const;
  /// Throws Error: the trace breaks the rule at this lane.
  [[noreturn]] void refuse(LaneId id, const char* rule) const;

  RtSchedulerConfig config_;
  std::unique_ptr<WarpSelection> selection_;
  unsigned entries_;
  bool boxes_;
  // The neighbours, looked up once; the last two are null if the configuration has none.
  WarpTable* buffer_ = nullptr;
  node_fetch_if* memory_ = nullptr;
  const NodeTraffic* traffic_ = nullptr;
  any_hit_if* any_hit_ = nullptr;
  checkpoint_if* checkpoint_ = nullptr;
  stack_if* stack_ = nullptr;
  RtSchedulerCounters counters_;
};

}  // namespace grtx::modules
