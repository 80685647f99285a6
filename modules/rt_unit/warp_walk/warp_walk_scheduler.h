// SPDX-License-Identifier: Apache-2.0
// Warp walk scheduler of the RT unit, in the place of the RT scheduler: a warp has one stack of nodes and the lanes
// that visit them, and several of its entries are under way at once. Each node is fetched once for all its lanes.
// Beyond the paper. Cost: the stack, a node slot for each entry under way, queues of hits. docs/model/warp_walk.md has
// the timing.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <iosfwd>
#include <systemc>
#include <utility>
#include <vector>

#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/ring_queue.h"
#include "grtx/modules/kernel/unit_probe.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/rt_unit/scheduler/scheduler_base.h"
#include "grtx/modules/rt_unit/stack/decide/stack_entry.h"
#include "grtx/modules/rt_unit/warp_walk/decide/warp_stack.h"
#include "grtx/traces/header.h"

namespace grtx::modules {

/// Tag of a lane's test: warp, node slot and lane. A lane may be in several tests at once.
constexpr LaneId walk_test(unsigned entry, unsigned slot, unsigned lane) {
  return static_cast<LaneId>((entry * WarpStackConfig::kMostAhead + slot) * kMaxLanes + lane);
}

class WarpWalkScheduler final : public SchedulerBase, public fetched_node_if, public Probed {
 public:
  using Config = WarpStackConfig;

  /// scheduler: the policy. entries: warps of the warp buffer. node_ports: nodes that a unit reads in a cycle. Throws
  /// Error for a trace that warps cannot walk.
  WarpWalkScheduler(const sc_core::sc_module_name& name, const Config& config, const RtSchedulerConfig& scheduler,
                    unsigned entries, const traces::Header& header, unsigned node_ports);

  void begin(unsigned entry) override;
  void schedule(Cycle now) override;
  SelectableWarp at(unsigned entry) const override;
  /// Passes lanes of fetched nodes to their units, and writes children to the stacks.
  void prepare(Cycle now) override;
  void fetched(Cycle now, unsigned entry, LaneMask slots, traces::NodeKind kind) override;
  void unit_result(Cycle now, LaneId test) override;
  void stack_settled(LaneId id) override;
  void any_hit_done(Cycle now, const AnyHitDone& done) override;
  void entry_read(LaneId) override {}     // no replay
  void entries_taken(LaneId) override {}  // no checkpoints
  fetched_node_if* fetched_nodes() override { return this; }

  Inventory inventory() const override;
  std::vector<UnitProbe> probes() const override;
  void dump_state(std::ostream& out) const override;
  void restart() override;

 private:
  struct LaneWalk {
    LaneTree tree;
    RingQueue<std::uint32_t> hits;  ///< events; the first is at the any-hit part
    std::uint32_t left = 0;         ///< events that are not done
  };
  struct Walk {
    explicit Walk(WarpStack of_warp) : stack(std::move(of_warp)) {}
    WarpStack stack;
    std::vector<LaneWalk> lanes = std::vector<LaneWalk>(kMaxLanes);
    std::deque<unsigned> done;  ///< slots of finished nodes whose children are not all on the stack yet
    std::size_t next = WarpStack::kNone;
    unsigned fetching = 0;                 ///< slots whose node has not arrived
    unsigned testing = 0;                  ///< tests of lanes in the units
    unsigned hits = 0;                     ///< not answered
    unsigned held = 0;                     ///< places reserved for hits, by leaf tests and by hits
    bool moving = false, filling = false;  ///< the stack unit works for this warp
  };
  /// Nodes that have been fetched and whose tests do not all have a place in the queue of their unit, and tests there.
  struct Entering {
    RingQueue<LaneId> nodes;  ///< lane_id(entry, slot)
    unsigned tests = 0;       ///< queued or in pipelines
  };
  void end_of_elaboration() override;
  bool is_leaf(traces::NodeKind kind) const { return traces::without_width(kind) == leaf_; }
  bool can_enter(const Entering& unit) const {
    return !unit.nodes.empty() && (stacks_.tests == 0 || unit.tests < stacks_.tests);
  }
  void enter(Cycle now, Entering& unit);
  unsigned children_in_node(unsigned entry, const WarpStackEntry& node) const;
  void write_children();
  /// Starts the entry at `place` of the warp's stack.
  void start(Cycle now, unsigned entry, std::size_t place);
  /// Counts the events of an entry; returns the lanes that visit its node. The others cull it.
  LaneMask count_events(const WarpStackEntry& node, const Walk& walk);
  void node_done(unsigned entry, unsigned slot);
  void event_done(unsigned entry, unsigned lane);
  void found(Cycle now, unsigned entry, unsigned lane, std::uint32_t event);
  void offer(Cycle now, unsigned entry, unsigned lane);
  /// Writes the next child of the warp's first finished node, if it has room for all of them.
  bool write_child(unsigned entry);
  /// Entries come back from memory when none waits here.
  void refill(unsigned entry);
  void move(unsigned entry, std::size_t more, bool top);
  void refresh(unsigned entry);
  /// Updates whether the warp has children to write.
  void note_children(unsigned entry);

  Config stacks_;
  StackEntryLayout layout_;
  unsigned record_bits_;  ///< of a node, as read
  unsigned node_ports_;
  bool by_slot_;  ///< children are visited in slot order
  node_test_if* units_ = nullptr;
  traces::NodeKind leaf_{};
  std::vector<Walk> walks_;           ///< [entry]
  std::array<Entering, 2> entering_;  ///< nodes, leaves
  LaneMask writing_ = 0;              ///< entries whose warp has children to write
};

/// Throws Error unless warps can walk a trace with this header.
void require_walkable(const traces::Header& header);

}  // namespace grtx::modules
