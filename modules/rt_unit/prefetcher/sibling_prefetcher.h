// SPDX-License-Identifier: Apache-2.0
// Sibling prefetcher of the RT unit: the first demand fetch of a child leaf prefetches the siblings that were also hit;
// optionally, a replayed leaf prefetches the siblings that were checkpointed with it.
// Paper: Section V, "Simulation Infrastructure" (stands for undisclosed optimisations of real GPUs; not part of GRTX).
// Cost: a few records {node, hit children} per lane and a small queue.
#pragma once

#include <cassert>
#include <cstdint>
#include <iosfwd>
#include <systemc>
#include <vector>

#include "grtx/modules/kernel/bounded_queue.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/kernel/unit_probe.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/rt_unit/decide/node_traffic.h"
#include "grtx/modules/rt_unit/prefetcher/decide/prefetch_decisions.h"
#include "grtx/modules/rt_unit/prefetcher/prefetch_if.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

class SiblingPrefetcher final : public PrefetchModule, public Probed {
 public:
  using Config = PrefetcherConfig;
  using Counters = PrefetchCounters;
  using Triggers = PrefetchTriggers;
  SiblingPrefetcher(const sc_core::sc_module_name& name, const Config& config, const Triggers& triggers,
                    const NodeTraffic& traffic, unsigned entries);

  void begin_lane(LaneId id, std::uint16_t slot, bool replays) override {
    decisions_.begin_lane(id, std::size_t{slot} * kMaxLanes + lane_of(id), replays);
  }
  void begin_warp() override { decisions_.begin_warp(); }
  void note_internal(LaneId id, const traces::RayGroup& group, std::uint32_t definition, unsigned hit,
                     unsigned checkpointed) override {
    decisions_.note_internal(id, group, definition, hit, checkpointed);
  }
  void note_replayed(LaneId id, std::uint32_t address) override { decisions_.note_replayed(id, address); }
  void note_leaf(LaneId id, const traces::RayGroup& group, std::uint32_t address) override {
    if (const Siblings siblings = decisions_.take(id, group, address); siblings.mask != 0) {
      decisions_.ask_for(siblings, group, *this);
    }
  }

  void respond(Cycle now) override;
  void issue(Cycle now) override;
  bool busy() const override { return !queue_.empty(); }
  bool idle() const override { return queue_.empty() && outstanding_ == 0; }
  std::uint64_t progress() const override { return 0; }
  std::size_t queued() const { return queue_.size(); }        ///< nodes not fully requested
  std::uint64_t outstanding() const { return outstanding_; }  ///< sectors sent, not answered
  Counters counters() const override { return decisions_.counters(); }
  Inventory inventory() const override;
  std::vector<UnitProbe> probes() const override {
    return {{"queued", kLevelBits, [this] { return queued(); }},
            {"outstanding", kLevelBits, [this] { return outstanding(); }}};
  }
  void dump_state(std::ostream& out) const override;
  void restart() override;

 private:
  struct Pending {
    std::uint64_t address = 0;
    traces::NodeKind kind = traces::NodeKind::internal;
    std::uint8_t next = 0;
  };
  void end_of_elaboration() override;
  // This class is the Queue of PrefetchDecisions.
  friend PrefetchDecisions;
  bool waits(std::uint64_t address) const;
  bool full() const { return queue_.room() == 0; }
  void push(traces::NodeKind kind, std::uint64_t address) {
    queue_.push({address, kind, 0});
    awake_ = true;
  }

  Config config_;
  Triggers triggers_;
  std::size_t lanes_;
  const NodeTraffic& traffic_;
  PrefetchDecisions decisions_;
  LinkWriter<MemoryRequest> requests_;
  LinkReader<MemoryResponse> responses_;
  BoundedQueue<Pending> queue_;
  std::uint64_t outstanding_ = 0;
};

}  // namespace grtx::modules
