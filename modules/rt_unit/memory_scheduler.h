// Memory scheduler of the RT unit: merges equal node addresses of a warp into one fetch and issues it by sectors.
// Paper: Section IV-B ("fetches the node at the top of the traversal stack"; duplicate requests are merged).
// Cost: a queue of fetches not fully issued, and one record of lanes and missing sectors for each lane of the warp
// buffer.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <systemc>
#include <vector>

#include "grtx/modules/kernel/address_index.h"
#include "grtx/modules/kernel/bounded_queue.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/messages/node_fetch_messages.h"
#include "grtx/modules/messages/sampling.h"
#include "grtx/modules/rt_unit/decide/node_traffic.h"
#include "grtx/modules/rt_unit/decide/node_visit.h"
#include "grtx/modules/rt_unit/node_fetch_if.h"
#include "grtx/modules/rt_unit/warp_table.h"

namespace grtx::modules {

struct MemorySchedulerCounters {
  std::array<std::uint64_t, kRegionCount> visits{};   ///< lane visits
  std::array<std::uint64_t, kRegionCount> fetches{};  ///< after merging
  std::array<std::uint64_t, kRegionCount> sectors{};  ///< requests sent
  std::uint64_t shader_batches = 0;                   ///< by_shader: messages to the SIMT core
  std::uint64_t shader_sectors = 0;                   ///< by_shader: sectors asked of it, all of `sectors`
  Distribution fetch_latency;                         ///< cycles from the first lane's visit to the last sector
  std::uint64_t node_visits() const;
  std::uint64_t node_fetches() const;
  std::uint64_t node_sectors() const;
  static const CounterTable<MemorySchedulerCounters>& table();
  void add(const MemorySchedulerCounters& other) { table().add(*this, other); }
  void describe(StatisticList& list, const std::string& prefix) const { table().describe(*this, list, prefix); }
};

class MemoryScheduler final : public NodeFetchModule {
 public:
  struct Config {
    unsigned queue = 64;  ///< a warp is scheduled while 32 places are free
    bool merge_in_flight = true;
    bool by_shader = false;
    unsigned sectors_per_cycle = 1;
    NodeTrafficConfig traffic;
    Sampling sampling{};  ///< by the assembly
    void parameters(ParameterList& list) {
      list.add("queue", queue, {kMaxLanes, kMaxEntries}, "fetches", "node fetches waiting to be issued", kOurs);
      list.add("merge_in_flight", merge_in_flight, "a fetch also merges with one of its warp that is still under way",
               from_public("Vulkan-Sim merges within one cycle only"));
      list.add("by_shader", by_shader, "the SIMT core reads the nodes, the RT unit only intersects (as on AMD)",
               from_paper("GRTX, Section IV: the RT unit does"));
      list.add("sectors_per_cycle", sectors_per_cycle, {1, 4}, "sectors/cycle",
               "width of the RT unit's port for nodes at the L1; 4 are the 128 B of recent GPUs", kVulkanSim)
          .came_later();
      list.rule(
          "sectors_per_cycle", [this] { return std::has_single_bit(sectors_per_cycle); }, kSectorsRule);
      traffic.parameters(list);
    }
  };
  using Counters = MemorySchedulerCounters;
  MemoryScheduler(const sc_core::sc_module_name& name, const Config& config, const traces::Header& header,
                  unsigned entries);

  const NodeTraffic& traffic() const override { return traffic_; }
  bool has_room() const override { return queue_.room() >= kMaxLanes; }
  /// Only visits between two calls merge (and those in flight, if asked).
  void begin_warp(Cycle now, unsigned entry) override;
  void visit(LaneId id, traces::NodeKind kind, std::uint64_t address, bool header) override;
  bool has_touch() const override { return true; }
  void touch(const NodeVisit& node, Cycle at) override { touch_node(node, at); }
  void count_visit(const NodeVisit& node) override;
  Cycle remaining(unsigned entry, const NodeVisit& node, Cycle now) const override;

  /// Takes at most sectors_per_cycle responses, or one batch that the SIMT core has read.
  void respond(Cycle now) override;
  /// Sends at most sectors_per_cycle sectors, or the fetches at the front of the queue that belong to one warp.
  void issue(Cycle now) override;
  bool busy() const override { return !queue_.empty(); }

  std::size_t queued() const { return queue_.size(); }        ///< fetches not fully issued
  std::uint64_t outstanding() const { return outstanding_; }  ///< sectors sent, not answered
  bool idle() const override { return queue_.empty() && outstanding_ == 0; }
  std::uint64_t progress() const override { return counters_.node_sectors() + counters_.fetch_latency.count(); }
  Counters counters() const override { return counters_; }
  Inventory inventory() const override;
  void dump_state(std::ostream& out) const override;
  void restart() override;

 private:
  struct Fetch {
    NodeVisit node;
    LaneMask lanes = 0;
    Cycle asked = 0;
    std::uint8_t sectors = 0;  ///< to send
    std::uint8_t missing = 0;  ///< responses not yet back
    Touched found;             ///< in a sampled run, by sector
  };
  struct Pending {
    LaneId fetch = 0;
    std::uint8_t next = 0;  ///< sector to send next
  };
  static std::uint64_t merge_key(std::uint64_t address, bool header);
  void end_of_elaboration() override;
  void issue_sectors(Cycle now);
  void take_batch_done(Cycle now);
  void issue_batch(Cycle now);
  void complete(Cycle now, LaneId fetch);
  Touched touch_node(const NodeVisit& node, Cycle at);
  SectorAccess sector_of(const Fetch& fetch, const NodeSectors& sectors, unsigned index) const;
  NodeFetchBatch take_batch(unsigned entry, std::uint16_t slot);

  Config config_;
  const traces::Header& header_;
  NodeTraffic traffic_;
  WarpTable* warps_ = nullptr;
  fetched_node_if* fetched_node_ = nullptr;
  touch_if* cache_ = nullptr;     ///< null where everything takes time
  double usual_latency_ = 200.0;  ///< of a fetch, cycles
  LinkWriter<MemoryRequest> requests_;
  LinkReader<MemoryResponse> responses_;
  LinkWriter<NodeFetchBatch> batches_;
  LinkReader<NodeFetchDone> batches_done_;
  std::vector<Fetch> fetches_;       ///< by the lane that asked first: a lane has at most one visit under way
  std::vector<LaneMask> under_way_;  ///< by entry: lanes that lead a fetch
  BoundedQueue<Pending> queue_;
  std::optional<NodeSectors> front_;    ///< of the fetch at the front of the queue, once it has begun
  std::vector<AddressIndex> merge_;     ///< by entry: finds the fetch, by leading lane, that a visit may join
  std::vector<std::uint64_t> visited_;  ///< without merging in flight: keys of the present warp's visits
  unsigned visited_entry_ = 0;
  Cycle now_ = 0;
  std::uint64_t outstanding_ = 0;  ///< sectors sent, not answered
  Counters counters_;
};

}  // namespace grtx::modules
