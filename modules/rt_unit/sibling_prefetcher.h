// Sibling prefetcher of the RT unit: the first demand fetch of a child leaf prefetches the siblings that were also hit.
// Its queue and port also serve nodes of source entries (checkpoint unit) and of the traversal stack (StackPrefetch).
// Paper: Section V, "Simulation Infrastructure" (stands for undisclosed optimisations of real GPUs; not part of GRTX).
// Cost: a few records {node, hit children} a lane and a small queue.
#pragma once

#include <cassert>
#include <cstdint>
#include <iosfwd>
#include <span>
#include <systemc>

#include "grtx/modules/kernel/bounded_queue.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/rt_unit/decide/node_traffic.h"
#include "grtx/modules/rt_unit/decide/sibling_records.h"
#include "grtx/modules/rt_unit/decide/stack_prefetch.h"
#include "grtx/modules/rt_unit/prefetch_if.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

class SiblingPrefetcher final : public PrefetchModule {
 public:
  static constexpr unsigned kMaxRecords = 8;
  struct Config {
    unsigned records = 4;   ///< a new one replaces the oldest
    unsigned queue = 32;    ///< a prefetch that finds it full is dropped
    bool replayed = false;  ///< a replayed leaf brings the siblings that were checkpointed with it
    StackPrefetch::Config stack{};
    /// But for the stack, which is a table of its own.
    void parameters(ParameterList& list) {
      list.add("records", records, {1, kMaxRecords}, "nodes", "internal visits remembered a lane", kOurs);
      list.add("queue", queue, {1, kMaxEntries}, "nodes", "prefetches waiting to be issued", kOurs);
      list.add("replayed", replayed, "a replayed leaf brings the siblings that were checkpointed with it",
               assumed("this project: off; GRTX, Section V, says any child leaf node"));
    }
  };
  struct Counters {
    std::uint64_t triggers = 0;  ///< internal visits whose siblings were prefetched
    std::uint64_t nodes = 0;     ///< sibling nodes queued
    std::uint64_t merged = 0;    ///< sibling nodes that another lane had just asked for or that were queued already
    std::uint64_t dropped = 0;   ///< sibling nodes that found the queue full
    std::uint64_t sectors = 0;   ///< requests sent
    std::uint64_t responses = 0;
    std::uint64_t replayed = 0;       ///< of triggers
    std::uint64_t entry_nodes = 0;    ///< nodes that source entries name, queued
    std::uint64_t entry_merged = 0;   ///< ... that were queued already
    std::uint64_t entry_dropped = 0;  ///< ... that found the queue full
    std::uint64_t stack_looks = 0;    ///< times that a lane's stack was looked at
    std::uint64_t stack_nodes = 0;    ///< nodes of stack entries queued
    std::uint64_t stack_merged = 0;   ///< ... that were queued already
    std::uint64_t stack_dropped = 0;  ///< ... that found the queue full
    std::uint64_t stack_culled = 0;   ///< of stack_nodes, those whose entry is culled in the end
    static const CounterTable<Counters>& table();
    void add(const Counters& other) { table().add(*this, other); }
    void describe(StatisticList& list, const std::string& prefix) const { table().describe(*this, list, prefix); }
  };

  /// What triggers it.
  struct Triggers {
    bool siblings = true;   ///< leaves bring their siblings
    bool replayed = false;  ///< also those that are replayed
  };
  SiblingPrefetcher(const sc_core::sc_module_name& name, const Config& config, const Triggers& triggers,
                    const NodeTraffic& traffic, unsigned entries);

  /// A lane begins a round: what it remembers is void.
  void begin_lane(LaneId id, std::uint16_t slot, bool replays, const traces::RayGroup& group,
                  std::span<const traces::Event> events) override {
    records_.begin(id, std::size_t{slot} * kMaxLanes + lane_of(id), replays);
    if (stacks_.enabled()) stacks_.begin(id, group, events);
  }
  void note_internal(LaneId id, const traces::RayGroup& group, std::uint32_t definition, unsigned hit,
                     unsigned checkpointed) override {
    if (triggers_.siblings) records_.note(id, group, definition, hit, checkpointed);
  }
  void note_replayed(LaneId id, std::uint32_t address) override { records_.note_replayed(id, address); }
  /// Starts the visits of one warp in one cycle.
  void begin_warp() override { asked_.begin(); }
  /// The lane asks for the leaf at `address` (in units).
  void note_leaf(LaneId id, const traces::RayGroup& group, std::uint32_t address) override;
  void note_entry(traces::NodeKind kind, std::uint64_t address) override;
  bool reads_stacks() const override { return stacks_.enabled(); }
  void note_stack(LaneId id, std::uint32_t left, std::uint32_t on_chip) override;

  void respond(Cycle now) override;
  void issue(Cycle now) override;
  bool busy() const override { return !queue_.empty(); }
  bool idle() const override { return queue_.empty() && outstanding_ == 0; }
  std::uint64_t progress() const override { return 0; }
  void count(RtUnitCounters& all) const override;
  std::size_t queued() const { return queue_.size(); }        ///< nodes not fully asked for
  std::uint64_t outstanding() const { return outstanding_; }  ///< sectors sent, not answered
  const Counters& counters() const { return counters_; }
  Inventory inventory() const override;
  void dump_state(std::ostream& out) const override;

 private:
  struct Pending {
    std::uint64_t address = 0;
    traces::NodeKind kind = traces::NodeKind::internal;
    std::uint8_t next = 0;
  };
  void end_of_elaboration() override;
  bool push(traces::NodeKind kind, std::uint64_t address, std::uint64_t& merged, std::uint64_t& dropped);

  Config config_;
  Triggers triggers_;
  const NodeTraffic& traffic_;
  LinkWriter<MemoryRequest> requests_;
  LinkReader<MemoryResponse> responses_;
  SiblingRecords records_;
  SiblingRequests asked_;
  StackPrefetch stacks_;
  BoundedQueue<Pending> queue_;
  std::uint64_t outstanding_ = 0;
  Counters counters_;
};

}  // namespace grtx::modules
