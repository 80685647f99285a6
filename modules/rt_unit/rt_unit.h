// RT unit of an SM: warp buffer, RT scheduler, memory scheduler, intersection units, any-hit collector, checkpoint unit
// and sibling prefetcher, assembled into one clocked block. Paper: Section IV, Figure "arch". Cost: the sum of its
// parts. docs/model/rt_scheduler.md gives the order of the stages in a cycle.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <string>
#include <systemc>
#include <vector>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/kernel/statistics.h"
#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/rt_unit/any_hit_collector.h"
#include "grtx/modules/rt_unit/checkpoint_unit.h"
#include "grtx/modules/rt_unit/intersection_unit.h"
#include "grtx/modules/rt_unit/memory_scheduler.h"
#include "grtx/modules/rt_unit/rt_scheduler.h"
#include "grtx/modules/rt_unit/sibling_prefetcher.h"
#include "grtx/modules/rt_unit/stack_unit.h"
#include "grtx/modules/rt_unit/warp_buffer.h"
#include "grtx/traces/header.h"

namespace grtx::sim {

struct RtUnitConfig {
  modules::WarpBuffer::Config warp_buffer;
  modules::RtScheduler::Config scheduler;
  modules::MemoryScheduler::Config memory;
  // Latencies and counts: UBC 2024 (generalized TTA); no public source gives a ray-sphere unit, it takes the
  // triangle's.
  modules::IntersectionUnit::Config ray_box{4, 13, 1};
  modules::IntersectionUnit::Config ray_triangle{4, 37, 1};
  modules::IntersectionUnit::Config ray_sphere{4, 37, 1};
  modules::IntersectionUnit::Config ray_transform{4, 4, 1};
  bool box_op_per_child = false;  ///< a box operation tests one child, not the whole node
  modules::AnyHitCollector::Config any_hit;
  modules::CheckpointUnit::Config checkpoint;
  bool sibling_prefetch = true;
  modules::SiblingPrefetcher::Config prefetcher;
};

/// Raw counts of one RT unit, or of several added up. Counters of units that were not elaborated stay 0.
struct RtUnitCounters {
  std::uint64_t units = 0;  ///< RT units added up
  modules::WarpBuffer::Counters warp_buffer;
  modules::RtScheduler::Counters scheduler;
  modules::MemoryScheduler::Counters memory;
  modules::IntersectionUnit::Counters ray_box;
  modules::IntersectionUnit::Counters ray_triangle;
  modules::IntersectionUnit::Counters ray_sphere;
  modules::IntersectionUnit::Counters ray_transform;
  modules::AnyHitCollector::Counters any_hit;
  modules::CheckpointUnit::Counters checkpoint;
  modules::SiblingPrefetcher::Counters prefetch;
  modules::StackUnit::Counters stack;

  void add(const RtUnitCounters& other);
  /// cycles: length of the run, for the mean occupancy of a warp buffer.
  void describe(modules::StatisticList& list, const std::string& prefix, Cycle cycles) const;
};

class RtUnit final : public modules::ClockedModule {
 public:
  modules::LinkIn<modules::TraceCall> trace_call;        ///< in, from the SIMT core
  modules::LinkOut<modules::TraceDone> trace_done;       ///< out
  modules::LinkOut<modules::AnyHitBatch> any_hit_batch;  ///< out
  modules::LinkIn<modules::AnyHitDone> any_hit_done;     ///< in
  /// L1 client for node fetches, unless the shader cores fetch the nodes (fetches_nodes()).
  modules::OptionalLinkOut<modules::MemoryRequest> node_request;
  modules::OptionalLinkIn<modules::MemoryResponse> node_response;
  modules::OptionalLinkOut<modules::NodeFetchBatch>
      node_fetch;  ///< out, to the SIMT core; used when the shader cores fetch
  modules::OptionalLinkIn<modules::NodeFetchDone> node_fetch_done;
  /// L1 client for checkpoint traffic; used when the trace has checkpointing (has_checkpoint()), else may stay unbound.
  modules::OptionalLinkOut<modules::MemoryRequest> checkpoint_request;
  modules::OptionalLinkIn<modules::MemoryResponse> checkpoint_response;
  /// L1 client for prefetches; used with sibling_prefetch (has_prefetcher()), else may stay unbound.
  modules::OptionalLinkOut<modules::MemoryRequest> prefetch_request;
  modules::OptionalLinkIn<modules::MemoryResponse> prefetch_response;
  /// L1 client for stack entries; used when stacks spill (has_stack()), else may stay unbound.
  modules::OptionalLinkOut<modules::MemoryRequest> stack_request;
  modules::OptionalLinkIn<modules::MemoryResponse> stack_response;

  /// sm: number of the SM, selects its per-ray buffers in the map. map and domain must outlive the unit.
  RtUnit(const sc_core::sc_module_name& name, const RtUnitConfig& config, const traces::Header& header,
         const modules::MemoryMap& map, modules::ClockDomain& domain, unsigned sm);

  bool has_checkpoint() const { return checkpoint_ != nullptr; }
  bool has_prefetcher() const { return prefetcher_ != nullptr; }
  bool has_stack() const { return stack_ != nullptr; }
  bool fetches_nodes() const { return !config_.memory.by_shader; }
  /// Nothing inside: no warp, no request, no response due. Links are not looked at.
  bool idle() const;
  /// Grows with all that the unit does; for a watchdog.
  std::uint64_t progress() const;
  /// Closes per-cycle counts at `end`, the first cycle that does not count. Call before counters() or statistics().
  void settle(Cycle end);
  /// First cycle that per-cycle counts do not cover yet; after the last warp it may lie beyond the cycle of retirement,
  /// when writes or prefetches were still under way.
  Cycle accounted() const { return accounted_; }
  RtUnitCounters counters() const;
  /// Warps in the warp buffer summed over the cycles before `end`, of a running unit.
  std::uint64_t warp_cycles_until(Cycle end) const { return warp_buffer_.occupancy_until(end); }
  std::uint64_t selections() const { return scheduler_.counters().selections; }
  void statistics(modules::StatisticList& list, const std::string& prefix) const;
  /// Of all parts, in block-diagram order.
  std::vector<modules::Inventory> inventory() const;
  void dump_state(std::ostream& out) const;

 private:
  void end_of_elaboration() override;
  Cycle tick(Cycle now) override;
  void run_stages(Cycle now);
  void take_responses(Cycle now);
  void take_fetch(Cycle now, const modules::MemoryScheduler::Completed& fetch);
  void issue_requests(Cycle now);
  void invoke_any_hit(Cycle now);
  void retire(Cycle now);
  void accept(Cycle now);
  Cycle next_due(Cycle now) const;
  Cycle next_arrival() const;
  modules::IntersectionUnit& unit_of(traces::NodeKind kind);
  template <typename F>
  void for_each_unit(F&& f) const {
    for (modules::IntersectionUnit* unit : units_) f(*unit);
  }

  RtUnitConfig config_;
  modules::WarpBuffer warp_buffer_;
  modules::MemoryScheduler memory_;
  modules::AnyHitCollector any_hit_;
  std::unique_ptr<modules::CheckpointUnit> checkpoint_;
  std::unique_ptr<modules::SiblingPrefetcher> prefetcher_;
  std::unique_ptr<modules::StackUnit> stack_;
  modules::RtScheduler scheduler_;
  std::unique_ptr<modules::IntersectionUnit> ray_box_;
  std::unique_ptr<modules::IntersectionUnit> ray_triangle_;
  std::unique_ptr<modules::IntersectionUnit> ray_sphere_;
  std::unique_ptr<modules::IntersectionUnit> ray_transform_;

  std::vector<modules::IntersectionUnit*> units_;  ///< those that exist, in the order above

  // The channels behind the ports, looked up once.
  modules::LinkReader<modules::TraceCall> calls_;
  modules::LinkWriter<modules::TraceDone> dones_;
  modules::LinkWriter<modules::AnyHitBatch> batches_;
  modules::LinkReader<modules::AnyHitDone> shader_dones_;
  modules::LinkWriter<modules::MemoryRequest> node_requests_;
  modules::LinkReader<modules::MemoryResponse> node_responses_;
  modules::LinkWriter<modules::MemoryRequest> checkpoint_requests_;
  modules::LinkReader<modules::MemoryResponse> checkpoint_responses_;
  modules::LinkWriter<modules::MemoryRequest> prefetch_requests_;
  modules::LinkReader<modules::MemoryResponse> prefetch_responses_;
  modules::LinkWriter<modules::MemoryRequest> stack_requests_;
  modules::LinkReader<modules::MemoryResponse> stack_responses_;
  modules::LinkWriter<modules::NodeFetchBatch> fetch_batches_;
  modules::LinkReader<modules::NodeFetchDone> fetches_done_;

  Cycle due_ = modules::kNever;  ///< next cycle in which the unit has something to do of its own
  Cycle accounted_ = 0;          ///< first cycle whose stall reason has not been counted
  Cycle settled_ = 0;
};

}  // namespace grtx::sim
