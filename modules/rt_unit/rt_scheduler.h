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
#include "grtx/modules/rt_unit/event_sampler.h"
#include "grtx/modules/rt_unit/scheduler_if.h"
#include "grtx/modules/rt_unit/warp_table.h"

namespace grtx::modules {

/// Counters of warps that walk together; 0 if each lane has a stack.
struct WarpWalkCounters {
  std::uint64_t entries = 0;       ///< started, or dropped
  std::uint64_t dropped = 0;       ///< beyond t_max of all their lanes
  std::uint64_t in_vain = 0;       ///< tests of lanes for which the node is beyond t_max
  std::uint64_t under_way = 0;     ///< entries of the warp under way at a start, itself included, summed over starts
  std::uint64_t most_waiting = 0;  ///< most entries of a warp that waited, in memory or not
};

struct RtSchedulerCounters {
  std::uint64_t selections = 0, lanes_handled = 0, lanes_active = 0;
  std::array<std::uint64_t, kStalls> stall{};
  // Trace events executed.
  std::uint64_t visits_internal = 0, visits_instance = 0, visits_leaf = 0, culls = 0;
  std::uint64_t replay_takes = 0, replay_forwards = 0, any_hit_calls = 0, intersection_calls = 0;
  WarpWalkCounters walk;
  std::uint64_t events() const {
    return visits_internal + visits_instance + visits_leaf + culls + replay_takes + replay_forwards;
  }
  double simt_efficiency() const {
    return lanes_active == 0 ? 0.0 : static_cast<double>(lanes_handled) / static_cast<double>(lanes_active);
  }
  static const CounterTable<RtSchedulerCounters>& table();
  void add(const RtSchedulerCounters& other) { table().add(*this, other); }
  void describe(StatisticList& list, const std::string& prefix) const { table().describe(*this, list, prefix); }
};

/// What one of the project's schedulers did in a cycle, for observers.
class RtSchedulerState {
 public:
  /// Stall reason of the current state, which idle cycles are counted under.
  virtual Stall stall_reason() const = 0;
  virtual RtSchedulerCounters counters() const = 0;

 protected:
  ~RtSchedulerState() = default;
};

class RtScheduler final : public RtSchedulerModule, public RtSchedulerState, public functional_events_if {
 public:
  struct Config {
    std::string policy = "oldest_first";  ///< name of a WarpSelection
    Sampling sampling{};                  ///< set by the assembly
    void parameters(ParameterList& list) {
      list.add("policy", policy, warp_selection_names(), "which warp is served in a cycle", kVulkanSim);
    }
  };
  using Counters = RtSchedulerCounters;

  /// entries: warps of the warp buffer. boxes: primitive leaves are boxes.
  RtScheduler(const sc_core::sc_module_name& name, const Config& config, unsigned entries, bool boxes);

  void begin(unsigned entry) override;
  void schedule(Cycle now) override;
  bool has_touch() const override { return true; }
  void touch_until(Cycle now) override { sampler_->touch_until(now); }
  void touch_event(LaneId id, const traces::Event& event, Cycle at) override;
  void note_event(LaneId id, const traces::Event& event) override;
  void execute(LaneId id, Cycle at) override;
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
  void execute_visit(LaneId id, Cycle at);
  void replay(LaneId id, LaneState from);
  /// State of a lane whose last event is done.
  LaneState end_state(LaneId id) const {
    return any_hit_->holds(id) ? LaneState::waiting_any_hit : LaneState::finished;
  }
  /// Applies the lane's event to its stack depth.
  void move_stack(LaneId id);
  [[noreturn]] void refuse(LaneId id, const char* rule) const;

  Config config_;
  std::unique_ptr<WarpSelection> selection_;
  std::unique_ptr<EventSampler> sampler_;  ///< null unless the run is sampled
  unsigned entries_;
  bool boxes_;
  // The neighbours, looked up once; the last four are null if the configuration has none.
  WarpTable* buffer_ = nullptr;
  node_fetch_if* memory_ = nullptr;
  const NodeTraffic* traffic_ = nullptr;
  any_hit_if* any_hit_ = nullptr;
  checkpoint_if* checkpoint_ = nullptr;
  prefetch_if* prefetcher_ = nullptr;
  stack_if* stack_ = nullptr;
  shader_touch_if* shader_ = nullptr;
  Counters counters_;
};

}  // namespace grtx::modules
