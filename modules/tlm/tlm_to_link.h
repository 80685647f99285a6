// SPDX-License-Identifier: Apache-2.0
// Bridge from a TLM-2.0 target socket to a pair of links, so that a TLM initiator can drive a module with link ports:
// an L1 client port, an L2 slice, a crossbar input. Accepts approximately timed and blocking transactions, also mixed.
// No hardware: it is the boundary of the model.
#pragma once

#include <tlm_utils/simple_target_socket.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <iosfwd>
#include <memory>
#include <systemc>
#include <tlm>
#include <vector>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

class FunctionalMemory;

/// A call that takes effect at time t is seen at the first clock edge after t. The transaction is split into the 32 B
/// sectors that it touches, one per cycle. When all are answered, BEGIN_RESP is called, or b_transport returns, in the
/// cycle in which the last response is visible. So a single sector costs, from the edge that sees it,
///   latency of the request link + latency of the module behind it, including its response link.
/// Caches and links carry no data: Config::data reads or writes it when the last response has arrived, and at once for
/// transport_dbg. A thread that is killed or reset inside b_transport leaves its transaction to end without it: no data
/// are read or written. Addresses beyond kAddressable are answered with TLM_ADDRESS_ERROR_RESPONSE. DMI would bypass
/// the model, so it is refused unless Config::dmi is set.
class TlmToLink final : public ClockedModule {
 public:
  struct Config {
    /// Most transactions in flight; further ones wait in their request phase. The default exceeds an L1's round trip in
    /// cycles, so that hits stream.
    unsigned outstanding = 64;
    Region region = Region::tlas;  ///< region under which caches count the sectors
    std::uint8_t client = 0;       ///< as in MemoryRequest; overwritten by an L1
    std::uint8_t sm = 0;           ///< as in MemoryRequest; overwritten by an L1
    /// Functional access to the modelled memory, like transport_dbg: returns the number of bytes read or written; fewer
    /// than requested is an address error. If not set, the bridge has a memory of its own, initially 0.
    std::function<unsigned(::tlm::tlm_generic_payload&)> data = nullptr;
    std::function<bool(::tlm::tlm_generic_payload&, ::tlm::tlm_dmi&)> dmi =
        nullptr;  ///< implements get_direct_mem_ptr; refused if not set
  };

  TlmToLink(const sc_core::sc_module_name& name, const Config& config, ClockDomain& clock);
  ~TlmToLink() override;

  tlm_utils::simple_target_socket<TlmToLink, 32> socket;
  LinkOut<MemoryRequest> request;   ///< produced here
  LinkIn<MemoryResponse> response;  ///< consumed here

  bool idle() const { return inside_ == 0 && arriving_ == nullptr && responding_ == nullptr; }
  std::uint64_t transactions() const { return transactions_; }  ///< transactions answered
  std::uint64_t sectors() const { return sectors_; }            ///< sectors sent
  std::uint64_t refused() const { return refused_; }  ///< malformed transactions, answered with an error status
  void dump_state(std::ostream& out) const;

 private:
  class BlockingCall;
  struct Transaction {
    ::tlm::tlm_generic_payload* payload = nullptr;  ///< null: the thread of a blocking call was killed or reset
    sc_core::sc_event* done = nullptr;              ///< notified when a blocking call is complete; else null
    std::uint64_t next_sector = 0;
    std::uint64_t to_send = 0;  ///< sectors not sent yet
    std::uint64_t to_come = 0;  ///< responses not received yet; 0: slot is free
    bool write = false;
  };

  void end_of_elaboration() override;
  ::tlm::tlm_sync_enum nb_transport_fw(::tlm::tlm_generic_payload& payload, ::tlm::tlm_phase& phase,
                                       sc_core::sc_time& delay);
  void b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time& delay);
  unsigned transport_dbg(::tlm::tlm_generic_payload& payload);
  bool get_direct_mem_ptr(::tlm::tlm_generic_payload& payload, ::tlm::tlm_dmi& dmi) {
    return config_.dmi(payload, dmi);
  }
  bool room() const { return inside_ < config_.outstanding; }
  static ::tlm::tlm_response_status check(const ::tlm::tlm_generic_payload& payload);
  bool refuse(::tlm::tlm_generic_payload& payload);
  ::tlm::tlm_sync_enum reject(::tlm::tlm_generic_payload& payload, const char* rule);
  std::uint32_t enter(::tlm::tlm_generic_payload& payload, sc_core::sc_event* done);
  Cycle tick(Cycle now) override;
  void restart(Caches caches) override;
  void free_all();
  void take_responses(Cycle now);
  void answer(const Transaction& transaction);
  void take_arrival(Cycle now);
  void send_sector(Cycle now);
  void begin_response(Cycle now);
  void end_response(Cycle free_from);
  void leave();

  Config config_;
  std::unique_ptr<FunctionalMemory> memory_;  ///< where Config::data is not set
  std::function<unsigned(::tlm::tlm_generic_payload&)> data_;
  std::vector<Transaction> slots_;
  std::vector<std::uint32_t> free_;
  std::deque<std::uint32_t> sending_;                 ///< slots with sectors to send, oldest first
  std::deque<::tlm::tlm_generic_payload*> answered_;  ///< complete non-blocking transactions, BEGIN_RESP not sent yet
  ::tlm::tlm_generic_payload* arriving_ = nullptr;    ///< in its request phase
  Cycle arrival_ = 0;                                 ///< first cycle in which arriving_ is visible
  ::tlm::tlm_generic_payload* responding_ = nullptr;  ///< in its response phase
  Cycle response_free_ = 0;                           ///< first cycle in which the next response may begin
  sc_core::sc_event room_;
  unsigned inside_ = 0;
  std::uint64_t transactions_ = 0;
  std::uint64_t sectors_ = 0;
  std::uint64_t refused_ = 0;
};

}  // namespace grtx::modules
