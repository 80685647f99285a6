// A TLM-2.0 initiator behind a pair of links, so that any memory answers a module that asks for links: an L1 without an
// L2, a crossbar output, a unit under test. Approximately timed by default, blocking where the target has no other way.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <map>
#include <systemc>
#include <tlm>
#include <vector>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/tlm/at_initiator.h"

namespace grtx::modules {

/// A request that is visible in cycle c is sent in cycle c, one sector of 32 B a transaction, when fewer than
/// `outstanding` are under way and the previous request phase has ended. A response that takes effect at time t enters
/// the response link at the first clock edge after t. An error status ends the simulation with a report.
/// Links carry no data: a write rewrites what the target holds (its transport_dbg says what), so that a memory with
/// data of others stays as it is. Who has data writes it functionally: TlmToLink::Config::data.
class LinkToTlm final : public ClockedModule {
 public:
  struct Config {
    unsigned outstanding = 64;  ///< requests under way
    bool blocking = false;      ///< calls b_transport from a thread, one call a cycle, the returned delay as latency
  };

  using SC_CURRENT_USER_MODULE = LinkToTlm;  // SC_HAS_PROCESS, which SystemC 3 deprecates
  LinkToTlm(const sc_core::sc_module_name& name, const Config& config, ClockDomain& clock);

  LinkIn<MemoryRequest> request;     ///< consumed here
  LinkOut<MemoryResponse> response;  ///< produced here
  AtInitiator memory;                ///< bind memory.socket; addresses are those of the requests

  bool idle() const { return free_.size() == slots_.size() && memory.idle(); }
  std::uint64_t requests() const { return requests_; }
  void dump_state(std::ostream& out) const;

 private:
  void end_of_elaboration() override;
  Cycle tick(Cycle now) override;
  void take_completion(Cycle now);
  void send(Cycle now);
  void call();
  bool answer(Cycle now, std::uint32_t slot);

  Config config_;
  std::vector<MemoryRequest> slots_;
  std::vector<std::uint32_t> free_;
  // Blocking calls.
  AtPayloadPool pool_;
  sc_core::sc_event called_;
  bool calling_ = false;
  Cycle next_call_ = 0;
  std::uint32_t calling_slot_ = 0;
  std::multimap<Cycle, std::uint32_t> returned_;  ///< slots by the cycle in which the response is visible
  std::uint64_t requests_ = 0;
};

}  // namespace grtx::modules
