// SPDX-License-Identifier: Apache-2.0
// SIMT core of an SM (paper, Section IV and Listing 1): runs the ray generation shader of each resident warp and the
// any-hit shader that the RT unit invokes. Four in-order warp schedulers (Table I) and a load-store unit.
// Cost: that of the SM; GRTX adds nothing here. docs/model/simt_core.md has the timing to the cycle.
#pragma once

#include <bit>
#include <cstdint>
#include <iosfwd>
#include <span>
#include <string>
#include <systemc>
#include <vector>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/kernel/ring_queue.h"
#include "grtx/modules/messages/hit_heap.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/messages/node_fetch_messages.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/simt/decide/issue_slots.h"
#include "grtx/modules/simt/decide/service_order.h"
#include "grtx/modules/simt/decide/shader_program.h"
#include "grtx/modules/simt/load_store_unit.h"
#include "grtx/modules/simt/simt_core_if.h"

namespace grtx::modules {

class SimtCore final : public SimtCoreModule {
 public:
  /// `map` must outlive the module. Throws Error if the header or the configuration is outside what the core can run.
  SimtCore(const sc_core::sc_module_name& name, ClockDomain& domain, const SimtCoreConfig& config,
           const traces::Header& header, const MemoryMap& map);

  bool idle() const override;
  unsigned resident() const;
  unsigned slots() const { return static_cast<unsigned>(slots_.size()); }
  bool occupied(unsigned slot) const { return slots_[slot].step != Step::free; }
  /// Activity of the warp in a slot. Like group() and round(), requires an occupied slot.
  WarpActivity activity(unsigned slot) const { return slots_[slot].activity; }
  const traces::RayGroup& group(unsigned slot) const { return *program_.group(slot); }
  std::uint32_t round(unsigned slot) const { return program_.round(slot); }
  const LoadStoreUnit& load_store() const { return lsu_; }
  /// Last cycle in which tick() did any work; the visible state has not changed since.
  Cycle last_active() const { return last_active_; }
  SimtCounters counters() const override;
  void statistics(StatisticList& list, const std::string& prefix) const { describe(counters(), list, prefix); }
  Inventory inventory() const override;
  void dump_state(std::ostream& out) const override;

 private:
  /// Progress of a warp's ray generation shader.
  enum class Step : std::uint8_t { free, prologue, evict_move, trace_call, tracing, sort, blend, epilogue, draining };
  friend constexpr auto enum_names(Step) {
    return names_in_order<Step>(
        {"free", "prologue", "evict_move", "trace_call", "tracing", "sort", "blend", "epilogue", "draining"});
  }

  /// Shader that a warp executes for the RT unit while the RT unit traces the warp's rays.
  enum class Service : std::uint8_t { none, any_hit, node_fetch, intersection };

  /// The links to one RT unit, looked up once; the last two are null unless shaders fetch nodes.
  struct RtLinks {
    LinkWriter<TraceCall> trace_call;
    LinkReader<TraceDone> trace_done;
    LinkReader<AnyHitBatch> any_hit_batch;
    LinkWriter<AnyHitDone> any_hit_done;
    LinkReader<NodeFetchBatch> node_fetch;
    LinkWriter<NodeFetchDone> node_fetch_done;
  };
  struct NodesFetched {
    std::uint16_t slot = 0;
    NodeFetchDone done;
  };

  struct Slot {
    Step step = Step::free;
    Service service = Service::none;  ///< running service for the RT unit (step is tracing)
    WarpActivity activity = WarpActivity::raygen;
    Cycle since = 0;       ///< start of this activity
    Cycle ready = kNever;  ///< cycle in which the instructions of the running phase are done
    PhaseKind kind = PhaseKind::prologue;
    std::uint64_t instructions = 0;    ///< of the running phase, not yet issued
    std::vector<SectorAccess> stores;  ///< stores of the running phase
    std::vector<SectorAccess> loads;   ///< loads of a phase with steps
    std::vector<std::uint32_t> steps;  ///< steps of the running phase
    std::size_t next_step = 0;         ///< first step whose loads have not been sent
    Cycle drained = 0;                 ///< cycle in which the heap's last entry is taken out; 0: none pending
    std::uint64_t step_instructions = 0;
    LaneMask any_hit_lanes = 0;  ///< lanes of the running batch
    AnyHitBatch hits;            ///< hits found by the intersection shader, for the any-hit shader
    NodeFetchDone fetched;       ///< answer to the running node fetch
  };

  void start_of_simulation() override;
  Cycle tick(Cycle now) override;
  void restart(Caches caches) override;
  Cycle earliest_due() const;
  void accept_response(Cycle now);
  void finish_drains(Cycle now);
  void accept_messages(Cycle now);
  void finish_phases(Cycle now);
  bool more_steps(unsigned slot) const { return slots_[slot].next_step < slots_[slot].steps.size(); }
  void load_step(unsigned slot, Cycle now);
  void finish_ray_generation(unsigned slot, Cycle now);
  void finish_service(unsigned slot, Cycle now);
  void start_service(unsigned slot, Cycle now);
  /// Stores a hit that fell out of its heap.
  void store_evicted(const AnyHitBatch& batch);
  void start_any_hit(unsigned slot, const AnyHitBatch& batch, Cycle now);
  void start_ray_generation(unsigned slot, Cycle now);
  void fill_phase(unsigned slot);
  void load(unsigned slot, Cycle now);
  /// Sends the loads of a phase, or of one step of it.
  void send_loads(unsigned slot, std::span<const SectorAccess> loads, Cycle now);
  void issue(unsigned slot, Cycle now);
  void send(Cycle now);
  void next_round(unsigned slot);
  void store(unsigned slot);
  void end_if_drained(unsigned slot, Cycle now);
  void enter(unsigned slot, WarpActivity activity, Cycle now);

  SimtCoreConfig config_;
  const traces::Header& header_;
  const MemoryMap& map_;
  ShaderProgram program_;
  IssueSlots issue_slots_;
  LoadStoreUnit lsu_;
  std::vector<Slot> slots_;
  ShaderPhase phase_;            ///< scratch
  ServiceOrder waiting_;         ///< not started yet
  Cycle next_ready_ = kNever;    ///< earliest Slot::ready
  Cycle next_drained_ = kNever;  ///< earliest Slot::drained
  Cycle last_active_ = 0;
  // Warp slots (one bit each) with work in the current cycle.
  WarpMask starting_service_ = 0;
  WarpMask starting_ray_generation_ = 0;
  WarpMask loaded_ = 0;  ///< all loads of the phase have returned
  // Messages to send, at most one of each kind per cycle.
  RingQueue<std::uint16_t> trace_calls_;
  RingQueue<AnyHitDone> any_hits_done_;
  RingQueue<NodesFetched> nodes_fetched_;
  RingQueue<std::uint16_t> ends_;
  SimtCounters counters_;

  // The ports' links, looked up once.
  LinkReader<LaunchWarp> launch_;
  LinkWriter<WarpEnded> ended_;
  std::vector<RtLinks> rt_;
  LinkWriter<MemoryRequest> memory_request_;
  LinkReader<MemoryResponse> memory_response_;
};

}  // namespace grtx::modules
