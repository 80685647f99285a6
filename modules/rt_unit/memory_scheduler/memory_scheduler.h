// SPDX-License-Identifier: Apache-2.0
// Memory scheduler of the RT unit: merges equal node addresses of a warp into one fetch and issues it sector by sector.
// Paper: Section IV-B ("fetches the node at the top of the traversal stack"; duplicate requests are merged).
// Cost: a queue of fetches not fully issued, and per lane of the warp buffer a record of lanes and missing sectors.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <systemc>
#include <vector>

#include "grtx/modules/kernel/bounded_queue.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/kernel/ring_queue.h"
#include "grtx/modules/kernel/unit_probe.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/messages/node_fetch_messages.h"
#include "grtx/modules/rt_unit/decide/node_traffic.h"
#include "grtx/modules/rt_unit/decide/node_visit.h"
#include "grtx/modules/rt_unit/memory_scheduler/decide/fetch_merge.h"
#include "grtx/modules/rt_unit/memory_scheduler/decide/memory_scheduler_config.h"
#include "grtx/modules/rt_unit/memory_scheduler/node_fetch_if.h"
#include "grtx/modules/rt_unit/warp_buffer/warp_table.h"

namespace grtx::modules {

class MemoryScheduler final : public NodeFetchModule, public Probed {
 public:
  using Config = MemorySchedulerConfig;
  using Counters = MemorySchedulerCounters;

  /// entries: warps of the warp buffer. holds_nodes: what has been fetched stays here until its last test.
  MemoryScheduler(const sc_core::sc_module_name& name, const Config& config, const traces::Header& header,
                  unsigned entries, bool holds_nodes = true);

  const NodeTraffic& traffic() const override { return traffic_; }
  bool has_room() const override { return queue_.room() >= kMaxLanes; }
  /// Visits merge only with those since the last call, and, with merge_in_flight, with pending fetches of the warp.
  void begin_warp(Cycle now, unsigned entry) override;
  void visit(LaneId id, traces::NodeKind kind, std::uint64_t address, bool header) override;
  void count_visit(const NodeVisit& node) override;

  /// Receives at most sectors_per_cycle responses, or one batch from the SIMT core.
  void respond(Cycle now) override;
  /// Sends at most sectors_per_cycle sectors, or one batch: the fetches of one warp at the front of the queue.
  void issue(Cycle now) override;
  bool busy() const override { return !queue_.empty() || !hits_.empty() || !second_reads_.empty(); }

  std::size_t queued() const { return queue_.size(); }        ///< fetches not fully issued
  std::uint64_t outstanding() const { return outstanding_; }  ///< sectors sent, not answered
  bool idle() const override { return queue_.empty() && outstanding_ == 0 && second_reads_.empty(); }
  std::uint64_t progress() const override { return counters_.node_sectors() + counters_.fetch_latency.count(); }
  Counters counters() const override { return counters_; }
  Inventory inventory() const override;
  std::vector<UnitProbe> probes() const override;
  void dump_state(std::ostream& out) const override;
  void restart() override;

 private:
  struct Fetch {
    NodeVisit node;
    LaneMask lanes = 0;
    Cycle asked = 0;
    NodePart part = NodePart::whole;
    std::uint8_t sectors = 0;  ///< number of sectors
    std::uint8_t missing = 0;  ///< responses missing
  };
  struct Pending {
    LaneId fetch = 0;
    std::uint8_t next = 0;  ///< sector to send next
  };
  /// A sector that the L1 held when it was asked for.
  struct Hit {
    Cycle due = 0;
    LaneId fetch = 0;
  };
  /// The second read of a visit whose first has come.
  struct SecondRead {
    Cycle due = 0;
    unsigned entry = 0;
    LaneMask lanes = 0;
    NodeVisit node;
  };
  void end_of_elaboration() override;
  void issue_sectors(Cycle now);
  bool request_sector(Cycle now, const MemoryRequest& sector);
  void take_hits(Cycle now);
  void begin_second_reads(Cycle now);
  void take_sector(Cycle now, LaneId fetch);
  void open(LaneId id, const Fetch& fetch, const NodeSectors& sectors, std::uint64_t key);
  void put_behind_older_warps();
  bool join(LaneId id, LaneMask lanes, const NodeVisit& node, NodePart part, std::uint64_t key);
  void take_batch_done(Cycle now);
  void issue_batch(Cycle now);
  void complete(Cycle now, LaneId fetch);
  NodeFetchBatch take_batch(unsigned entry, std::uint16_t slot);

  Config config_;
  const traces::Header& header_;
  NodeTraffic traffic_;
  bool holds_nodes_;
  bool reads_twice_;  ///< some visits are two reads
  WarpTable* warps_ = nullptr;
  fetched_node_if* fetched_node_ = nullptr;
  LinkWriter<MemoryRequest> requests_;
  LinkReader<MemoryResponse> responses_;
  LinkWriter<NodeFetchBatch> batches_;
  LinkReader<NodeFetchDone> batches_done_;
  std::vector<Fetch> fetches_;            ///< [LaneId of the first lane], as a lane has at most one visit in flight
  std::vector<LaneMask> under_way_;       ///< [entry] first lanes of the pending fetches
  read_at_once_if* l1_ = nullptr;         ///< if rt.memory.l1_hit_latency says so
  RingQueue<Hit> hits_;                   ///< by due cycle
  std::vector<SecondRead> second_reads_;  ///< by due cycle, then as their first reads came
  BoundedQueue<Pending> queue_;
  std::optional<NodeSectors> front_;  ///< sectors of the fetch at the front of the queue, once begun
  FetchMerge merge_;
  Cycle now_ = 0;
  std::uint64_t outstanding_ = 0;  ///< sectors sent, not answered
  Counters counters_;
};

}  // namespace grtx::modules
