// SPDX-License-Identifier: Apache-2.0
// RT unit of an SM: the netlist of warp buffer, RT scheduler, memory scheduler, node dispatch, intersection units,
// any-hit collector or any-hit unit, checkpoint unit, stack unit and sibling prefetcher. Paper: Section IV, Figure
// "arch". Cost: the sum of its parts. It builds and binds the parts and calls their stages in order; all decisions are
// in the parts.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <string>
#include <systemc>
#include <vector>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/messages/node_fetch_messages.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/rt_unit/decide/warp_stack_config.h"
#include "grtx/modules/rt_unit/node_dispatch.h"
#include "grtx/modules/rt_unit/rt_unit_counters.h"
#include "grtx/modules/rt_unit/rt_unit_parts.h"
#include "grtx/traces/header.h"

namespace grtx::modules {

/// An RT unit as the SM and its observers see it.
class RtUnitModule : public ClockedModule {
 public:
  LinkIn<TraceCall> trace_call{"trace_call"};           ///< from the SIMT core
  LinkOut<TraceDone> trace_done{"trace_done"};          ///< one per call, in any order
  LinkOut<AnyHitBatch> any_hit_batch{"any_hit_batch"};  ///< a warp has at most one batch at the shader
  LinkIn<AnyHitDone> any_hit_done{"any_hit_done"};
  /// L1 client for node fetches; bound when fetches_nodes().
  OptionalLinkOut<MemoryRequest> node_request{"node_request"};
  OptionalLinkIn<MemoryResponse> node_response{"node_response"};
  /// To and from the SIMT core; used if the shaders fetch the nodes, i.e. when not fetches_nodes().
  OptionalLinkOut<NodeFetchBatch> node_fetch{"node_fetch"};
  OptionalLinkIn<NodeFetchDone> node_fetch_done{"node_fetch_done"};
  /// L1 client for checkpoint traffic; bound when has_checkpoint().
  OptionalLinkOut<MemoryRequest> checkpoint_request{"checkpoint_request"};
  OptionalLinkIn<MemoryResponse> checkpoint_response{"checkpoint_response"};
  /// L1 client for prefetches; bound when has_prefetcher().
  OptionalLinkOut<MemoryRequest> prefetch_request{"prefetch_request"};
  OptionalLinkIn<MemoryResponse> prefetch_response{"prefetch_response"};
  /// L1 client for stack entries; bound when has_stack().
  OptionalLinkOut<MemoryRequest> stack_request{"stack_request"};
  OptionalLinkIn<MemoryResponse> stack_response{"stack_response"};
  // Functional access to the L1 and the SIMT core in sampled runs.
  TouchPort<touch_if> touch_cache{"touch_cache"};
  TouchPort<shader_touch_if> touch_shader{"touch_shader"};

  virtual bool has_checkpoint() const = 0;
  virtual bool has_prefetcher() const = 0;
  virtual bool has_stack() const = 0;
  virtual bool fetches_nodes() const = 0;
  /// Whether nothing is inside: no warp, no request, no pending response. Does not consider the links.
  virtual bool idle() const = 0;
  /// Grows whenever the unit makes progress; for a watchdog.
  virtual std::uint64_t progress() const = 0;
  /// Completes the per-cycle counters up to `end` (exclusive). Call before counters().
  virtual void settle(Cycle end) = 0;
  virtual RtUnitCounters counters() const = 0;
  /// First cycle that the per-cycle counters do not cover yet. At the end it may be beyond the last warp's retirement,
  /// if writes or prefetches were still in flight.
  virtual Cycle accounted() const = 0;
  /// Number of cycles so far in which a warp was scheduled.
  virtual std::uint64_t selections() const = 0;
  /// Warps in the warp buffer summed over the cycles before `end`; may be called during a run.
  virtual std::uint64_t warp_cycles_until(Cycle end) const = 0;
  /// The inventories of all parts, in block-diagram order.
  virtual std::vector<Inventory> inventory() const = 0;
  virtual void dump_state(std::ostream& out) const = 0;

 protected:
  using ClockedModule::ClockedModule;
};

struct RtUnitConfig {
  WarpBuffer::Config warp_buffer;
  RtScheduler::Config scheduler;
  MemoryScheduler::Config memory;
  IntersectionUnit::Config ray_box = kRayBoxUnit;
  IntersectionUnit::Config ray_triangle = kRayTriangleUnit;
  IntersectionUnit::Config ray_sphere = kRaySphereUnit;
  IntersectionUnit::Config ray_gaussian = kRayGaussianUnit;
  IntersectionUnit::Config ray_transform = kRayTransformUnit;
  UnitImplementation box_implementation = UnitImplementation::tlm;
  UnitImplementation transform_implementation = UnitImplementation::tlm;
  TraversalWay traversal = TraversalWay::lane;
  WarpStackConfig warp_stack;  ///< traversal = warp
  bool gaussian_unit = false;  ///< procedural leaves are tested by ray-Gaussian instead of ray-sphere units
  bool box_op_per_child = false;
  AnyHitCollector::Config any_hit;
  AnyHitUnit::Config any_hit_unit;
  CheckpointUnit::Config checkpoint;
  bool sibling_prefetch = true;
  SiblingPrefetcher::Config prefetcher;
  Sampling sampling{};  ///< set by the assembly
  /// Data path of a ray-box pipeline for a trace with this header.
  DataPath box_path(const traces::Header& header) const {
    const traces::NodeSizes sizes = header.node_sizes();
    return ray_box_path(box_op_per_child ? 1 : header.bvh_width, sizes.decoder_priced());
  }
  /// Data path of a ray-transform pipeline for a trace with this header.
  static DataPath transform_path(const traces::Header& header) {
    return ray_transform_path(header.node_sizes().coded_transforms());
  }
  /// Whether an RT unit for a trace with this header has a prefetcher.
  bool has_prefetcher(const traces::Header&) const { return sibling_prefetch && !walks(); }
  /// Whether a warp has one stack. It then runs ahead by itself: there is no sibling prefetcher.
  bool walks() const { return traversal == TraversalWay::warp; }
  /// Whether checkpoint entries name the siblings written with them; 8 B entries have no room for that.
  bool names_siblings_in_entries(const traces::Header& header) const {
    return has_prefetcher(header) && prefetcher.replayed && header.checkpoint && checkpoint.entry_bytes != 8;
  }
  /// Whether ray-Gaussian units test the primitive leaves of a trace with this header.
  bool tests_gaussians(const traces::Header& header) const {
    return gaussian_unit && traces::has_procedural_leaves(header.accel) && !traces::has_box_leaves(header.accel);
  }
  /// The unit that tests the primitive leaves of a trace without boxes.
  const IntersectionUnit::Config& leaf_unit(const traces::Header& header) const {
    if (!traces::has_procedural_leaves(header.accel)) return ray_triangle;
    return gaussian_unit ? ray_gaussian : ray_sphere;
  }
  /// The any-hit unit's heaps as the SIMT core sees them.
  HitHeap heaps(const traces::Header& header) const {
    HitHeap heap = any_hit_unit;
    heap.alpha = tests_gaussians(header);
    return heap;
  }
  void parameters(ParameterList& list);
};

class RtUnit final : public RtUnitModule {
 public:
  /// sm: number of the SM, selects its per-ray buffers in the map. map and domain must outlive the unit. parts:
  /// factories of its parts. Throws Error for an impossible configuration.
  RtUnit(const sc_core::sc_module_name& name, const RtUnitConfig& config, const traces::Header& header,
         const MemoryMap& map, ClockDomain& domain, unsigned sm, const RtUnitParts& parts = {});

  bool has_checkpoint() const override { return checkpoint_ != nullptr; }
  bool has_prefetcher() const override { return prefetcher_ != nullptr; }
  bool has_stack() const override { return stack_ != nullptr; }
  bool fetches_nodes() const override { return !config_.memory.by_shader; }
  bool idle() const override;
  std::uint64_t progress() const override;
  void settle(Cycle end) override;
  RtUnitCounters counters() const override;
  std::uint64_t warp_cycles_until(Cycle end) const override { return warps_->occupancy_until(end); }
  std::vector<Inventory> inventory() const override;
  void dump_state(std::ostream& out) const override;

  Cycle accounted() const override { return accounted_; }
  std::uint64_t selections() const override { return scheduler_->selections(); }
  void statistics(StatisticList& list, const std::string& prefix) const;

 private:
  void build(const RtUnitParts& parts, const traces::Header& header);
  void build_scheduler(const RtUnitParts& parts, const traces::Header& header);
  void build_units(const RtUnitParts& parts, const traces::Header& header);
  void list_parts();
  void bind_parts();
  void bind_dispatch();
  void bind_optional_parts();
  void bind_touches();
  void end_of_elaboration() override;
  Cycle tick(Cycle now) override;
  void restart(Caches caches) override;
  void run_stages(Cycle now);
  void tick_units(Cycle now);
  Cycle next_due(Cycle now) const;
  Cycle next_arrival() const;
  template <typename F>
  void for_each_part(F&& f) const {
    for (RtPart* part : parts_) f(*part);
  }

  RtUnitConfig config_;
  NodeTraffic traffic_;
  RtUnitContext context_;
  std::unique_ptr<WarpBufferModule> warp_buffer_;
  std::unique_ptr<RtSchedulerModule> scheduler_;
  WarpWalkModule* walk_ = nullptr;  ///< the scheduler, if warps walk together
  std::unique_ptr<NodeFetchModule> memory_;
  NodeDispatch dispatch_;
  std::unique_ptr<AnyHitModule> any_hit_;
  std::unique_ptr<IntersectionModule> ray_box_;
  std::unique_ptr<IntersectionModule> ray_triangle_;
  std::unique_ptr<IntersectionModule> ray_sphere_;
  std::unique_ptr<IntersectionModule> ray_gaussian_;
  std::unique_ptr<IntersectionModule> ray_transform_;
  std::unique_ptr<CheckpointModule> checkpoint_;
  std::unique_ptr<PrefetchModule> prefetcher_;
  std::unique_ptr<StackModule> stack_;

  std::vector<RtPart*> parts_;              ///< existing parts, in block-diagram order
  std::vector<IntersectionModule*> units_;  ///< existing intersection units
  /// A part that is a client of the L1, with its response link.
  struct MemoryClient {
    RtMemoryPart* part = nullptr;
    LinkReader<MemoryResponse> responses;  ///< unset: respond() is called in every active cycle
  };
  std::vector<MemoryClient> clients_;  ///< existing clients, in stage order
  WarpTable* warps_ = nullptr;

  // Links that can wake the unit, looked up once.
  LinkReader<TraceCall> calls_;
  LinkReader<AnyHitDone> shader_dones_;
  LinkReader<NodeFetchDone> fetches_done_;

  Cycle due_ = kNever;   ///< next cycle with work even if nothing arrives
  Cycle accounted_ = 0;  ///< first cycle whose stall reason has not been counted
  Cycle settled_ = 0;
};

}  // namespace grtx::modules
