// SPDX-License-Identifier: Apache-2.0
// Delayed hits of the RT unit (Header::any_hit = delayed): the hits of a warp wait in memory until all of its lanes
// have traversed, then the shaders run, one hit of each lane at a time. Vulkan-Sim's model, and the baseline of
// GauTracer (ISCA 2026). This part takes the place of the any-hit collector. Cost: a counter per lane; the hits lie in
// memory. docs/model/rt_scheduler.md has the timing.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <iosfwd>
#include <systemc>
#include <vector>

#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/rt_unit/any_hit_collector/any_hit_if.h"
#include "grtx/modules/rt_unit/any_hit_collector/decide/any_hit_collector_config.h"
#include "grtx/modules/rt_unit/warp_buffer/warp_table.h"

namespace grtx::modules {

class DelayedHits final : public AnyHitModule {
 public:
  /// entries: warps of the warp buffer.
  DelayedHits(const sc_core::sc_module_name& name, unsigned entries);

  void arrive(Cycle now, LaneId id) override;
  bool holds(LaneId id) const override { return !hits_[id].empty(); }
  void finished(unsigned /*entry*/) override {}
  void invoke(Cycle now) override;
  Cycle next_due(Cycle now) const override { return due_entries() == 0 ? kNever : now + 1; }

  AnyHitCounters counters() const override { return counters_; }
  bool idle() const override { return held_ == 0; }
  std::uint64_t progress() const override { return counters_.batches; }
  Inventory inventory() const override;
  void dump_state(std::ostream& out) const override;
  void restart() override {
    for (std::deque<traces::Event>& hits : hits_) hits.clear();
    std::fill(held_of_.begin(), held_of_.end(), 0);
    held_ = 0;
    counters_ = {};
  }

 private:
  void end_of_elaboration() override;
  /// Entries whose lanes have all traversed, with hits left and no batch at the shader.
  WarpMask due_entries() const;
  void answer(const AnyHitDone& answered);
  void fire(Cycle now, unsigned entry);

  WarpTable* warps_ = nullptr;
  any_hit_client_if* client_ = nullptr;
  LinkWriter<AnyHitBatch> batches_;
  LinkReader<AnyHitDone> dones_;
  std::vector<std::deque<traces::Event>> hits_;  ///< [lane of the warp buffer] in the order found
  std::vector<std::uint64_t> held_of_;           ///< [entry] hits of its lanes
  std::uint64_t held_ = 0;
  AnyHitCounters counters_;
};

}  // namespace grtx::modules
