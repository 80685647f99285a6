// SPDX-License-Identifier: Apache-2.0
// Bridge from a pair of links to a TLM-2.0 initiator socket, so that a TLM memory can serve a module with link ports:
// an L1 without an L2, a crossbar output, a unit under test. Approximately timed by default; blocking for targets that
// offer nothing else.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <map>
#include <memory>
#include <systemc>
#include <tlm>
#include <vector>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/tlm/at_initiator.h"

namespace grtx::modules {

/// A request visible in cycle c is sent in cycle c as one 32 B transaction, if fewer than `outstanding` are in flight
/// and the previous request phase has ended. A response that takes effect at time t enters the response link at the
/// first clock edge after t. An error status ends the simulation with a report.
/// Links carry no data: a write rewrites the target's present contents (read by transport_dbg), so other users' data is
/// preserved. Data proper is written functionally, see TlmToLink::Config::data.
class LinkToTlm final : public ClockedModule {
 public:
  struct Config {
    unsigned outstanding = 64;  ///< most requests in flight
    bool blocking = false;  ///< call b_transport from a thread, one call per cycle; the returned delay is the latency
  };

  using SC_CURRENT_USER_MODULE = LinkToTlm;  // SC_HAS_PROCESS, which SystemC 3 deprecates
  LinkToTlm(const sc_core::sc_module_name& name, const Config& config, ClockDomain& clock);
  ~LinkToTlm() override;

  LinkIn<MemoryRequest> request;     ///< consumed here
  LinkOut<MemoryResponse> response;  ///< produced here
  AtInitiator memory;                ///< bind memory.socket to the target; request addresses are passed on unchanged

  bool idle() const { return free_.size() == slots_.size() && memory.idle(); }
  std::uint64_t requests() const { return requests_; }
  void dump_state(std::ostream& out) const;

 private:
  void end_of_elaboration() override;
  Cycle tick(Cycle now) override;
  void restart(Caches caches) override;
  void free_all();
  void take_completion(Cycle now);
  void send(Cycle now);
  void call();
  bool answer(Cycle now, std::uint32_t slot);

  Config config_;
  std::vector<MemoryRequest> slots_;
  std::vector<std::uint32_t> free_;
  // Blocking calls.
  std::unique_ptr<AtPayloadPool> pool_;
  sc_core::sc_event called_;
  bool calling_ = false;
  Cycle next_call_ = 0;
  std::uint32_t calling_slot_ = 0;
  std::multimap<Cycle, std::uint32_t> returned_;  ///< cycle in which the response becomes visible -> slot
  std::uint64_t requests_ = 0;
};

}  // namespace grtx::modules
