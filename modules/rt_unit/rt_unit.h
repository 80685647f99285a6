// SPDX-License-Identifier: Apache-2.0
// RT unit of an SM: the netlist of warp buffer, RT scheduler, memory scheduler, node dispatch, intersection units,
// any-hit collector or any-hit unit, checkpoint unit, stack unit and sibling prefetcher. Paper: Section IV, Figure
// "arch". Cost: the sum of its parts. It builds and binds the parts and calls their stages in order; all decisions are
// in the parts.
#pragma once

#include <array>
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
#include "grtx/modules/kernel/waiting_links.h"
#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/messages/node_fetch_messages.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/rt_unit/node_dispatch/node_dispatch.h"
#include "grtx/modules/rt_unit/rt_unit_if.h"
#include "grtx/modules/rt_unit/rt_unit_parts.h"
#include "grtx/traces/header.h"

namespace grtx::modules {

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
  void end_of_elaboration() override;
  Cycle tick(Cycle now) override;
  void restart(Caches caches) override;
  void run_stages(Cycle now);
  void tick_units(Cycle now);
  Cycle next_due(Cycle now) const;
  void add_client(unsigned place, RtMemoryPart* part, const LinkReader<MemoryResponse>& responses);
  bool is_awake(unsigned place) const { return (awake_ >> place & 1) != 0; }
  Cycle arrival(unsigned link) const;
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
  // In stage order. Also the bit of a part in awake_, and the number of its response link in waiting_.
  static constexpr unsigned kMemory = 0, kCheckpoint = 1, kPrefetch = 2, kStack = 3, kClients = 4;
  static constexpr unsigned kAnyHit = 4;        ///< in awake_; in waiting_, its link shader_dones_
  static constexpr unsigned kCalls = 5;         ///< in waiting_
  std::array<MemoryClient, kClients> clients_;  ///< without a part where the configuration has none
  std::uint32_t awake_ = 0;                     ///< RtPart::awake() of clients and any-hit part
  WaitingLinks waiting_{kCalls + 1};            ///< input links that hold something
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
