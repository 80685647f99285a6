// An SM in fast mode: the cycle model's SIMT core, and the RT unit and L1 of this mode. Advances by itself through the
// cycles in which something is due, as far as the memory's answers are known.
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
  /// Advances to `end` (not included).
  void run(Cycle end);
  /// So many of its requests have not crossed the crossbar in cycle `now`.
  void crossing(std::size_t backlog, Cycle now) { l1_.crossing(backlog, now); }
  /// Next cycle in which something is due, launches and replies of the memory included.
  Cycle next_due() const {
    const Cycle reply = replies_.empty() ? modules::kNever : replies_.front().due;
    return std::min({due_, launch_.next_visible(), reply});
  }
  bool idle() const;
  /// Closes per-cycle counts.
  void settle(Cycle end) { rt_->settle(end); }
  RtUnitCounters rt() const { return rt_->counters(); }
  modules::SimtCounters simt() const { return simt_->counters(); }
  modules::L1Counters l1() const { return l1_.counters(); }

 private:
  struct Pending {
    modules::MemoryResponse response;
    Cycle due = 0;  ///< earliest cycle to enter the link
  };
  /// A port of the L1 behind links; the node requests of the RT unit need none.
  struct Client {
    std::unique_ptr<modules::Link<modules::MemoryRequest>> request;
    std::unique_ptr<modules::Link<modules::MemoryResponse>> response;
    modules::RingQueue<Pending> hits;
    modules::RingQueue<Pending> fills;
    Cycle next = 0;                   ///< earliest cycle in which the L1 looks at the head; kNever: after the next fill
    Cycle ask_due = modules::kNever;  ///< when a request is there, and the L1 looks at it
    Cycle respond_due = modules::kNever;  ///< when a response may enter the link
    void request_changed() {
      ask_due = next == modules::kNever ? modules::kNever : std::max(next, request->next_visible());
    }
    void response_changed() {
      const Cycle hit = hits.empty() ? modules::kNever : hits.front().due;
      respond_due = fills.empty() ? hit : std::min(hit, fills.front().due);
    }
  };
  static constexpr std::uint8_t kNode = 0;
  static constexpr std::uint8_t kSimt = 1;

  unsigned add_client(const std::string& name, const SmLinks& links, std::size_t responses);
  void step(Cycle now);
  void ask_all(Cycle now);
  void take_reply(Cycle now);
  bool ask(Cycle now, Client& client, std::uint8_t number);
  void respond(Cycle now, Client& client);
  Cycle earliest() const;

  modules::ClockDomain clock_;
  modules::ProcessBundle bundle_;
  bool rotating_;
  FastL1 l1_;
  modules::RingQueue<FastMemory::Reply>& replies_;
  std::vector<Client> clients_;  ///< [0] stands for the RT unit's node requests
  modules::Link<modules::LaunchWarp> launch_;
  modules::Link<modules::WarpEnded> ended_;
  modules::Link<modules::TraceCall> calls_;
  modules::Link<modules::TraceDone> dones_;
  modules::Link<modules::AnyHitBatch> batches_;
  modules::Link<modules::AnyHitDone> shader_dones_;
  std::unique_ptr<modules::SimtCore> simt_;
  std::unique_ptr<FastRtUnit> rt_;
  std::size_t rt_client_ = 0;  ///< port whose responses the RT unit waits for: checkpoint reads
  unsigned first_client_ = 0;
  Cycle due_ = modules::kNever;
};

}  // namespace grtx::tlm
