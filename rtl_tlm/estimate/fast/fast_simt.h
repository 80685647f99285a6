// The SIMT core of an SM in fast mode: the phases of the shaders, each of which loads, computes and stores.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/simt/decide/issue_slots.h"
#include "grtx/modules/simt/decide/shader_program.h"
#include "grtx/modules/simt/simt_counters.h"
#include "grtx/rtl_tlm/estimate/fast/fast_l1.h"
#include "grtx/rtl_tlm/estimate/fast/timed_share.h"

namespace grtx::sim::fast {

class Distributor;
class RtUnit;

class Simt {
 public:
  Simt(Shared& shared, unsigned sm, L1& l1, RtUnit& rt, Distributor& distributor);
  Simt(const Simt&) = delete;

  /// A warp comes to a free slot in cycle `seen`.
  void launch(Cycle seen, unsigned slot, const traces::RayGroup& group);
  /// The RT unit calls the any-hit or the intersection shader, for lanes of the warp in an entry of its buffer.
  void serve(Cycle now, unsigned entry, const modules::AnyHitBatch& batch);
  /// The same without time.
  void warm_any_hit(const modules::AnyHitBatch& batch);

  // ---- Events
  /// The warp's loads are there, its phase has been executed, its call has left the RT unit, or its stores are done.
  void warp_event(Cycle now, unsigned slot);
  /// The L1 has answered a request of the warp.
  void answered(std::uint32_t slot, Cycle seen, bool write);

  const AnyHitWork& timed_any_hits() const { return timed_any_hits_; }
  const AnyHitWork& warming_any_hits() const { return warming_any_hits_; }
  modules::SimtCounters counters() const;

 private:
  enum class Step : std::uint8_t {
    launched,
    prologue,
    evict_move,
    trace_call,
    tracing,
    sort,
    blend,
    epilogue,
    draining
  };

  struct Warp {
    const traces::RayGroup* group = nullptr;
    Step step = Step::prologue;
    bool loading = false;     ///< the present phase's loads are on the way
    bool in_service = false;  ///< runs the any-hit shader
    LaneMask service_lanes = 0;
    modules::AnyHitBatch hits;  ///< that the intersection shader has found, for the any-hit shader
    unsigned entry = 0;         ///< of the warp buffer, of these
    modules::PhaseKind kind{};
    modules::WarpActivity activity{};
    Cycle since = 0;  ///< of the activity
    std::uint64_t instructions = 0;
    std::vector<modules::SectorAccess> stores;
    std::uint32_t store_writes = 0;            ///< the same, to the private store
    std::vector<modules::SectorAccess> loads;  ///< of a phase in steps
    std::vector<modules::LoadStep> steps;      ///< of the present phase
    std::size_t next_step = 0;                 ///< whose loads have not gone out
    std::uint64_t step_instructions = 0;
    std::uint32_t loads_pending = 0, stores_pending = 0;  ///< requests
    Cycle loads_seen = 0, stores_seen = 0;
    Cycle store_read = 0;           ///< when the last read of the private store is back
    std::uint32_t first_timed = 0;  ///< drawn: in which rounds its phases take time
  };

  /// Begins a phase that a warp has once a round. In one of `fast.stride` rounds it takes time, in the others none.
  void start(Cycle now, unsigned slot, Step step);
  /// The phase happens at once: caches and counts of the trace see it.
  void warm_phase(unsigned slot);
  void load(Cycle now, unsigned slot);
  void load_step(Cycle now, unsigned slot);
  /// The loads of a phase, or of a step of one.
  void send_loads(Cycle now, unsigned slot, std::span<const modules::SectorAccess> loads, std::uint32_t store_reads);
  void issue(Cycle now, unsigned slot);
  void store(Cycle now, unsigned slot);
  void service_ends(Cycle now, unsigned slot);
  void enter(Cycle now, Warp& warp, modules::WarpActivity activity);
  void add(Cycle at, unsigned slot) { shared_.agenda.add(at, {What::warp, sm_, slot}); }
  void start_any_hit(Cycle now, const modules::AnyHitBatch& batch);
  /// Fills the shared phase, and counts it with its memory instructions.
  void run_any_hit(const modules::AnyHitBatch& batch, AnyHitWork& counted);
  void run_intersection(const modules::AnyHitBatch& batch, AnyHitWork& counted);
  void warm_accesses();
  /// Consecutive sectors of a line and region are one request.
  template <typename F>
  void for_each_line(std::span<const modules::SectorAccess> sectors, F&& f) const;

  Shared& shared_;
  unsigned sm_;
  L1& l1_;
  RtUnit& rt_;
  Distributor& distributor_;
  modules::ShaderProgram program_;
  modules::IssueSlots issue_;
  modules::PrivateStore store_;
  std::vector<Warp> warps_;  ///< by slot
  modules::SimtCounters counters_;
  AnyHitWork timed_any_hits_, warming_any_hits_;
};

}  // namespace grtx::sim::fast
