// An SM in fast mode: the cycle model's SIMT core, and the RT unit and L1 of this mode. Advances by itself through the
// cycles in which something is due.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <systemc>
#include <vector>

#include "modules/clock_domain.h"
#include "modules/link.h"
#include "modules/simt_core.h"
#include "rtl_tlm/fast/fast_l1.h"
#include "rtl_tlm/fast/fast_memory.h"
#include "rtl_tlm/fast/fast_rt_unit.h"
#include "rtl_tlm/sm.h"

namespace grtx::tlm {

class FastSm final : public sc_core::sc_module {
 public:
  FastSm(const sc_core::sc_module_name& name, const GpuConfig& config, unsigned index, const traces::Header& header,
         const modules::MemoryMap& map, FastMemory& memory);

  /// A warp that the core sees in cycle `visible` (ascending from call to call).
  void launch(Cycle visible, const modules::LaunchWarp& warp) { launch_.push(visible - launch_.latency(), warp); }
  /// The next warp that has ended and is seen before `end`; false when there is none.
  bool take_ended(Cycle end, Cycle& seen, std::uint16_t& slot);
  /// When the next such warp is seen; kNever when none has ended.
  Cycle next_ended() const { return ended_.next_visible(); }
  /// Advances to `end` (not included).
  void run(Cycle end);
  /// Next cycle in which something is due, launches included.
  Cycle next_due() const { return std::min(due_, launch_.next_visible()); }
  bool idle() const;
  /// Closes per-cycle counts.
  void settle(Cycle end) { rt_->settle(end); }
  RtUnitCounters rt() const { return rt_->counters(); }
  modules::SimtCounters simt() const { return simt_->counters(); }
  modules::L1Counters l1() {
    l1_.drain();
    return l1_.counters();
  }

 private:
  struct Pending {
    modules::MemoryResponse response;
    Cycle due = 0;  ///< earliest cycle to enter the link
    std::uint64_t order = 0;
    bool operator<(const Pending& o) const { return due != o.due ? due > o.due : order > o.order; }  // for a heap
  };
  /// A port of the L1 behind links; the node requests and prefetches of the RT unit need none.
  struct Client {
    std::unique_ptr<modules::Link<modules::MemoryRequest>> request;
    std::unique_ptr<modules::Link<modules::MemoryResponse>> response;
    std::vector<Pending> answers;  ///< a heap, the earliest on top
    std::uint64_t asked = 0;
    Cycle next = 0;   ///< earliest cycle in which the L1 looks at the head
    Cycle taken = 0;  ///< when the L1 takes the head, which it has looked at; 0: it has not
    Cycle respond_next = 0;
    Cycle ask_due() const { return std::max(next, request->next_visible()); }
    Cycle respond_due() const {
      return answers.empty() ? modules::kNever : std::max(answers.front().due, respond_next);
    }
  };

  std::size_t add_client(const std::string& name, const SmLinks& links);
  void step(Cycle now);
  void ask(Cycle now, Client& client);
  void respond(Cycle now, Client& client);
  Cycle earliest() const;

  modules::ClockDomain clock_;
  modules::ProcessBundle bundle_;
  FastL1 l1_;
  std::vector<Client> clients_;
  modules::Link<modules::LaunchWarp> launch_;
  modules::Link<modules::WarpEnded> ended_;
  modules::Link<modules::TraceCall> calls_;
  modules::Link<modules::TraceDone> dones_;
  modules::Link<modules::AnyHitBatch> batches_;
  modules::Link<modules::AnyHitDone> shader_dones_;
  std::unique_ptr<modules::SimtCore> simt_;
  std::unique_ptr<FastRtUnit> rt_;
  Cycle due_ = modules::kNever;
  Cycle next_advance_ = 0;  ///< of the calendars
};

}  // namespace grtx::tlm
