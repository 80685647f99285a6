// SPDX-License-Identifier: Apache-2.0
// RT scheduler: selects one warp per cycle, passes the next event of its ready lanes to the units, and receives the
// results. Includes t-value validation: culling of stack entries beyond t_max, and of source entries when replaying.
// Paper: Section IV-B, "Baseline Architecture" and "Traversal Checkpointing and Replay". Cost: an age matrix.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <systemc>
#include <vector>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/rt_unit/decide/event_effect.h"
#include "grtx/modules/rt_unit/decide/node_visit.h"
#include "grtx/modules/rt_unit/decide/warp_selection.h"
#include "grtx/modules/rt_unit/rt_unit_config.h"
#include "grtx/modules/rt_unit/rt_unit_counters.h"
#include "grtx/modules/rt_unit/scheduler_if.h"
#include "grtx/modules/rt_unit/warp_table.h"

namespace grtx::modules {

/// Activity of one of the project's schedulers in a cycle, for observers.
class RtSchedulerState {
 public:
  /// Stall reason of the current state, which idle cycles are counted under.
  virtual Stall stall_reason() const = 0;
  virtual RtSchedulerCounters counters() const = 0;

 protected:
  ~RtSchedulerState() = default;
};

class RtScheduler final : public RtSchedulerModule, public RtSchedulerState {
 public:
  using Config = RtSchedulerConfig;
  using Counters = RtSchedulerCounters;

  /// entries: warps of the warp buffer. boxes: primitive leaves are boxes.
  RtScheduler(const sc_core::sc_module_name& name, const Config& config, unsigned entries, bool boxes);

  void begin(unsigned entry) override;
  void schedule(Cycle now) override;
  void unit_result(Cycle now, LaneId id) override;
  void entry_read(LaneId id) override;
  void entries_taken(LaneId id) override;
  void stack_settled(LaneId id) override;
  void any_hit_done(Cycle now, const AnyHitDone& done) override;
  std::uint64_t selections() const override { return counters_.selections; }
  void count_idle(Cycle cycles) override { counters_.stall[static_cast<std::size_t>(stall_reason())] += cycles; }

  Stall stall_reason() const override;
  Counters counters() const override { return counters_; }
  bool idle() const override { return true; }  // no state of its own: waiting lanes are in the warp buffer
  std::uint64_t progress() const override { return counters_.selections; }
  Inventory inventory() const override;
  void dump_state(std::ostream& out) const override;
  void restart() override;

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
  [[noreturn]] void refuse(LaneId id, const char* rule) const;

  Config config_;
  std::unique_ptr<WarpSelection> selection_;
  unsigned entries_;
  bool boxes_;
  // The neighbours, looked up once; the last three are null if the configuration has none.
  WarpTable* buffer_ = nullptr;
  node_fetch_if* memory_ = nullptr;
  const NodeTraffic* traffic_ = nullptr;
  any_hit_if* any_hit_ = nullptr;
  checkpoint_if* checkpoint_ = nullptr;
  prefetch_if* prefetcher_ = nullptr;
  stack_if* stack_ = nullptr;
  Counters counters_;
};

}  // namespace grtx::modules
