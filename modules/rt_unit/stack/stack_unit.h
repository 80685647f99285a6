// SPDX-License-Identifier: Apache-2.0
// Stack unit of the RT unit: a lane keeps the top of its traversal stack in the warp buffer and the rest in memory.
// Paper: the stack is "in the warp buffer", its depth is not given; spilling deeper entries is an assumption.
// Cost: a queue of lanes and one offset per lane. docs/model/stack_unit.md has the timing.
#pragma once

#include <algorithm>
#include <cstdint>
#include <iosfwd>
#include <string>
#include <systemc>
#include <vector>

#include "grtx/modules/kernel/bounded_queue.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/rt_unit/stack/decide/stack_counters.h"
#include "grtx/modules/rt_unit/stack/decide/stack_entry.h"
#include "grtx/modules/rt_unit/stack/decide/stack_spill.h"
#include "grtx/modules/rt_unit/stack/stack_if.h"

namespace grtx::modules {

class StackUnit final : public StackModule {
 public:
  using Counters = StackCounters;

  /// on_chip: entries per lane in the warp buffer, at least as many as a sector holds. warps: entries of the warp
  /// buffer. sm: number of the SM, selects its stack areas. stacks_of_a_warp: one for each lane, or one for all lanes,
  /// in the area of lane 0.
  StackUnit(const sc_core::sc_module_name& name, unsigned on_chip, const StackEntryLayout& entry, const MemoryMap& map,
            unsigned warps, unsigned sm, unsigned stacks_of_a_warp = kMaxLanes);

  void begin_lane(LaneId id, std::uint16_t slot) override;
  bool settle(LaneId id, std::uint32_t depth, bool takes_top) override;

  void respond(Cycle now) override;
  /// Sectors are sent in the order of settle() calls.
  void issue(Cycle now) override;

  bool busy() const override { return !queue_.empty(); }
  bool idle() const override { return queue_.empty() && outstanding_ == 0; }
  std::uint64_t progress() const override { return counters_.spills + counters_.fills + counters_.returned; }
  Counters counters() const override { return counters_; }
  Inventory inventory() const override;
  void dump_state(std::ostream& out) const override;
  void restart() override {
    std::fill(lanes_.begin(), lanes_.end(), LaneContext());
    queue_.clear();
    awake_ = false;
    outstanding_ = 0;
    counters_ = {};
  }

 private:
  struct LaneContext {
    std::uint64_t ray = 0;  ///< ray slot
    StackSpill::Lane stack;
    std::uint32_t next = 0;     ///< next sector of the stack area to write or read
    std::uint8_t to_spill = 0;  ///< sectors left to spill
  };
  void end_of_elaboration() override;
  /// Sends the lane's next sector. Returns true if it was its last spill.
  bool send(Cycle now, LaneId id);
  void count_move(const StackSpill::Lane& lane, const StackSpill::Move& move);

  StackSpill spill_;
  const MemoryMap& map_;
  stack_client_if* client_ = nullptr;
  LinkWriter<MemoryRequest> requests_;
  LinkReader<MemoryResponse> responses_;
  unsigned sm_;
  std::vector<LaneContext> lanes_;
  std::uint64_t stacks_;
  BoundedQueue<LaneId> queue_;  ///< never full, as each lane is in it at most once
  std::uint64_t outstanding_ = 0;
  Counters counters_;
};

}  // namespace grtx::modules
