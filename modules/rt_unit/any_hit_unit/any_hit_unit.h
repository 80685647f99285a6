// SPDX-License-Identifier: Apache-2.0
// Any-hit unit of the RT unit: takes the time of keeping each ray's k nearest hits in a heap in the registers of its
// warp, without a shader (GauTracer, ISCA 2026, "AGHU"). Which hits stay is in the trace
// (traces/rules/k_buffer.h). It takes the place of the any-hit collector. A hit that falls out while checkpointing
// is on goes to the SIMT core's load-store unit, which stores it. Cost: a comparator and an address per heap logic.
// docs/model/any_hit_unit.md has the timing.
#pragma once

#include <algorithm>
#include <cstdint>
#include <iosfwd>
#include <queue>
#include <systemc>
#include <vector>

#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/kernel/ring_queue.h"
#include "grtx/modules/kernel/unit_probe.h"
#include "grtx/modules/messages/hit_heap.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/rt_unit/any_hit_collector/any_hit_if.h"
#include "grtx/modules/rt_unit/any_hit_collector/decide/any_hit_collector_config.h"
#include "grtx/modules/rt_unit/any_hit_unit/decide/any_hit_unit_config.h"
#include "grtx/modules/rt_unit/warp_buffer/warp_table.h"

namespace grtx::modules {

class AnyHitUnit final : public AnyHitModule, public Probed {
 public:
  using Config = AnyHitUnitConfig;

  /// entries: warps of the warp buffer. k: entries of a heap. evicts: hits that fall out are stored (checkpointing).
  /// bounded: entries that opacity hides leave (Header::opacity_bound).
  AnyHitUnit(const sc_core::sc_module_name& name, const Config& config, unsigned entries, unsigned k, bool evicts,
             bool bounded);

  void begin_lane(LaneId id, unsigned preloaded) override { fill_[id] = static_cast<int>(preloaded); }
  void arrive(Cycle now, LaneId id) override;
  void finished(unsigned /*entry*/) override {}
  /// Answers the hits that are done; those that fall out are sent to be stored first, one per cycle.
  void invoke(Cycle now) override;
  Cycle next_due(Cycle now) const override;

  std::size_t held() const { return flights_.size() + evicting_.size(); }  ///< hits that are not answered yet
  AnyHitCounters counters() const override { return counters_; }
  bool idle() const override { return held() == 0; }
  std::uint64_t progress() const override { return counters_.unit.answers; }
  Inventory inventory() const override;
  std::vector<UnitProbe> probes() const override;
  void dump_state(std::ostream& out) const override;
  void restart() override;

 private:
  struct Flight {
    Cycle due = 0;
    std::uint64_t order = 0;
    LaneId lane = 0;
    bool operator>(const Flight& o) const { return due != o.due ? due > o.due : order > o.order; }
  };
  void end_of_elaboration() override;
  /// The hit's effect on the heap's number of entries, and its cycles.
  Cycle take(LaneId id, const traces::Event& event);
  /// The same of the entries that it hides.
  Cycle hide(LaneId id, unsigned hidden);
  /// Entries in a lane's heap. Hits of a warp that walks together may come in another order than in the trace.
  unsigned entries_of(LaneId id) const { return static_cast<unsigned>(std::clamp(fill_[id], 1, static_cast<int>(k_))); }
  bool evicts(traces::LeafOutcome outcome) const;
  void answer(Cycle now, LaneId id);

  Config config_;
  unsigned k_;
  bool evicts_;
  bool bounded_;
  WarpTable* warps_ = nullptr;
  any_hit_client_if* client_ = nullptr;
  LinkWriter<AnyHitBatch> batches_;
  std::vector<int> fill_;         ///< [lane of the warp buffer] hits that entered its heap less those that left
  std::vector<Cycle> free_from_;  ///< [heap logic]
  std::priority_queue<Flight, std::vector<Flight>, std::greater<>> flights_;
  RingQueue<LaneId> evicting_;  ///< hits that are done and wait to be sent
  std::uint64_t order_ = 0;
  AnyHitCounters counters_;
};

}  // namespace grtx::modules
