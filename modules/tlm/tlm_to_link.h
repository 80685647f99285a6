// A TLM-2.0 target in front of a pair of links, so that any initiator drives a module that asks for links: an L1 client
// port, an L2 slice, a crossbar input. Approximately timed and blocking calls, also mixed between transactions.
// Costs nothing in hardware: it stands at the edge of the model.
#pragma once

#include <tlm_utils/simple_target_socket.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <iosfwd>
#include <systemc>
#include <tlm>
#include <vector>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/tlm/functional_memory.h"

namespace grtx::modules {

/// A call that takes effect at time t is seen at the first clock edge after t. The transaction is cut into the 32 B
/// sectors that it touches, one a cycle; when all have been answered, BEGIN_RESP is called, or b_transport returns, in
/// the cycle in which the last response is visible. So a single sector costs, from the edge that sees it,
///   latency of the request link + latency of the module behind it, its response link included.
/// Caches and links carry no data. It is read, or written, where Config::data says when the last response has come.
/// transport_dbg goes there too, at once. A direct memory interface would pass the model by: only where Config::dmi
/// gives one.
class TlmToLink final : public ClockedModule {
 public:
  struct Config {
    /// Transactions inside; further ones wait in their request phase. More than an L1's round trip, so that hits
    /// stream.
    unsigned outstanding = 64;
    Region region = Region::tlas;  ///< what caches count the sectors as
    std::uint8_t client = 0;       ///< as in MemoryRequest; an L1 sets it by itself
    std::uint8_t sm = 0;           ///< as in MemoryRequest, where no L1 is in front
    /// Functional access without time, as transport_dbg of the memory that is modelled: returns the bytes that it has
    /// read or written; fewer than asked for are an address error. None: a memory of the bridge's own, all 0 at first.
    std::function<unsigned(::tlm::tlm_generic_payload&)> data = nullptr;
    std::function<bool(::tlm::tlm_generic_payload&, ::tlm::tlm_dmi&)> dmi =
        nullptr;  ///< get_direct_mem_ptr; none: refused
  };

  TlmToLink(const sc_core::sc_module_name& name, const Config& config, ClockDomain& clock);

  tlm_utils::simple_target_socket<TlmToLink, 32> socket;
  LinkOut<MemoryRequest> request;   ///< produced here
  LinkIn<MemoryResponse> response;  ///< consumed here

  bool idle() const { return inside_ == 0 && arriving_ == nullptr && responding_ == nullptr; }
  std::uint64_t transactions() const { return transactions_; }  ///< answered
  std::uint64_t sectors() const { return sectors_; }            ///< sent
  std::uint64_t refused() const { return refused_; }  ///< malformed transactions, answered with an error status
  void dump_state(std::ostream& out) const;

 private:
  struct Transaction {
    ::tlm::tlm_generic_payload* payload = nullptr;  ///< null: slot is free
    sc_core::sc_event* done = nullptr;              ///< of a blocking call
    std::uint64_t next_sector = 0;
    std::uint64_t to_send = 0;  ///< sectors
    std::uint64_t to_come = 0;  ///< responses
    bool write = false;
  };

  void end_of_elaboration() override;
  ::tlm::tlm_sync_enum nb_transport_fw(::tlm::tlm_generic_payload& payload, ::tlm::tlm_phase& phase,
                                       sc_core::sc_time& delay);
  void b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time& delay);
  unsigned transport_dbg(::tlm::tlm_generic_payload& payload) { return data_(payload); }
  bool get_direct_mem_ptr(::tlm::tlm_generic_payload& payload, ::tlm::tlm_dmi& dmi) {
    return config_.dmi(payload, dmi);
  }
  bool room() const { return inside_ < config_.outstanding; }
  static ::tlm::tlm_response_status check(const ::tlm::tlm_generic_payload& payload);
  bool refuse(::tlm::tlm_generic_payload& payload);
  void enter(::tlm::tlm_generic_payload& payload, sc_core::sc_event* done);
  Cycle tick(Cycle now) override;
  void take_responses(Cycle now);
  void take_arrival(Cycle now);
  void send_sector(Cycle now);
  void begin_response(Cycle now);
  void end_response(Cycle free_from);
  void leave();

  Config config_;
  FunctionalMemory memory_;
  std::function<unsigned(::tlm::tlm_generic_payload&)> data_;
  std::vector<Transaction> slots_;
  std::vector<std::uint32_t> free_;
  std::deque<std::uint32_t> sending_;                 ///< slots with sectors to send, oldest first
  std::deque<::tlm::tlm_generic_payload*> answered_;  ///< non-blocking, BEGIN_RESP not called
  ::tlm::tlm_generic_payload* arriving_ = nullptr;    ///< in its request phase
  Cycle arrival_ = 0;                                 ///< cycle from which it is seen
  ::tlm::tlm_generic_payload* responding_ = nullptr;  ///< in its response phase
  Cycle response_free_ = 0;                           ///< cycle from which the next response may begin
  sc_core::sc_event room_;
  unsigned inside_ = 0;
  std::uint64_t transactions_ = 0;
  std::uint64_t sectors_ = 0;
  std::uint64_t refused_ = 0;
};

}  // namespace grtx::modules
