// SPDX-License-Identifier: Apache-2.0
// RT scheduler: selects one warp per cycle, passes the next event of its ready lanes to the units, and receives the
// results. Includes t-value validation: culling of stack entries beyond t_max, and of source entries when replaying.
// Paper: Section IV-B, "Baseline Architecture" and "Traversal Checkpointing and Replay". Cost: an age matrix.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <systemc>

#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/rt_unit/decide/event_effect.h"
#include "grtx/modules/rt_unit/decide/node_visit.h"
#include "grtx/modules/rt_unit/scheduler/scheduler_base.h"

namespace grtx::modules {

class RtScheduler final : public SchedulerBase {
 public:
  using Config = RtSchedulerConfig;
  using Counters = RtSchedulerCounters;

  /// entries: warps of the warp buffer. boxes: primitive leaves are boxes.
  RtScheduler(const sc_core::sc_module_name& name, const Config& config, unsigned entries, bool boxes);

  void begin(unsigned entry) override;
  void schedule(Cycle now) override;
  SelectableWarp at(unsigned entry) const override;
  void unit_result(Cycle now, LaneId id) override;
  void entry_read(LaneId id) override;
  void entries_taken(LaneId id) override;
  void stack_settled(LaneId id) override;
  void any_hit_done(Cycle now, const AnyHitDone& done) override;
  Inventory inventory() const override;
  void dump_state(std::ostream& out) const override;

 private:
  void end_of_elaboration() override;
  /// The lane's event is done: writes its checkpoint entries and moves the lane from state `from` to the next one.
  void complete(LaneId id, unsigned checkpoints, LaneState from);
  /// Submits the checkpoint entries of the lane's last event, once its stack is settled.
  void hand_over(LaneId id, unsigned checkpoints, LaneState from);
  void visit(LaneId id, const Warp& warp, const traces::Event& event);
  void count_visit(const traces::Event& event);
  void count_shader_call(const EventEffect& effect);
  NodeVisit node_of(LaneId id, const traces::Event& event) const;
  void replay(LaneId id, LaneState from);
  /// Tells the prefetcher of an event.
  void note_event(LaneId id, const traces::Event& event);
  /// State of a lane whose last event is done.
  LaneState end_state(LaneId id) const {
    return any_hit_->holds(id) ? LaneState::waiting_any_hit : LaneState::finished;
  }
  /// Applies the lane's event to its stack depth.
  void move_stack(LaneId id);

  prefetch_if* prefetcher_ = nullptr;  ///< null if the configuration has none
};

}  // namespace grtx::modules
