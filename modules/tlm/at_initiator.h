// SPDX-License-Identifier: Apache-2.0
// Initiator side of the TLM-2.0 AT base protocol, used by an L2 slice towards its DRAM channel. Any base-protocol
// target with a 32-bit socket fits: the built-in Dram or an external DRAM simulator. IEEE 1666-2011, clauses 14 and 15.
#pragma once

#include <tlm_utils/simple_initiator_socket.h>
#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <tlm>
#include <utility>

#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/kernel/ring_queue.h"
#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

class AtPayload;
class AtPayloadPool;

/// A member of a clocked module, which must call update() first in each tick. One request is in its request phase at a
/// time; back-pressure is a withheld END_REQ. Responses are always accepted, in any order. BEGIN_RESP is answered with
/// TLM_ACCEPTED, and END_RESP is a separate forward call that takes effect one clock later, because targets with their
/// own time grid (DRAMSys 5.1) round the times of calls but not of return values. Anything that arrives at time t is
/// visible to the module at its first edge after t, which is booked in the clock domain.
class AtInitiator final {
 public:
  struct Completion {
    std::uint32_t context = 0;
    bool write = false;
    ::tlm::tlm_response_status status = ::tlm::TLM_INCOMPLETE_RESPONSE;
    std::uint64_t address = 0;  ///< as given to send()
    Cycle visible = 0;
    bool ok() const { return status == ::tlm::TLM_OK_RESPONSE; }
  };
  /// SystemC report type for errors of the memory; the text is "socket: place: rule".
  static constexpr const char* kReport = "/grtx/memory";

  AtInitiator(const char* socket_name, ClockDomain& clock);
  ~AtInitiator();
  AtInitiator(const AtInitiator&) = delete;
  AtInitiator& operator=(const AtInitiator&) = delete;
  /// Must be called first in each tick: sends an END_RESP that is due.
  void update(Cycle now) {
    if (end_cycle_ <= now) end_response(now);
  }
  /// Registers the module's alarm, set for each arrival. Without one the clock domain's tick() is requested instead.
  void wake(Alarm* process) { process_ = process; }

  tlm_utils::simple_initiator_socket<AtInitiator, 32> socket;

  /// Whether the last request phase has ended, as seen in cycle `now`.
  bool can_send(Cycle now) const { return requesting_ == nullptr && free_from_ <= now; }
  /// bytes: a power of two up to AtPayload::kMaxBytes. address: a multiple of bytes. context: returned with the
  /// completion. origin: sent as an OriginExtension. Read data is discarded; writes write 0 unless keep_data() was
  /// called: there is no data in the model.
  void send(std::uint64_t address, unsigned bytes, bool write, std::uint32_t context, RequestOrigin origin = {});
  /// For a memory shared with other initiators: writes then carry the contents that the target has when they are sent,
  /// read by transport_dbg; 0 if it has no debug transport.
  void keep_data() { keeps_data_ = true; }
  /// Added to the address of every request on the bus; a multiple of AtPayload::kMaxBytes.
  void set_base(std::uint64_t base) { base_ = base; }
  /// `refused` hears of completions that are not ok(), with the address on the bus; without it they are error reports.
  using Refused = std::function<void(std::uint64_t address, const std::string& what)>;
  void on_refusal(Refused refused) { refused_ = std::move(refused); }
  /// Until restart() nothing more is sent; the memory's answers are taken as before.
  void hold() {
    held_ = true;
    free_from_ = kNever;
  }
  /// Fills a write payload with the present contents of the memory; called before it is sent.
  void fill(AtPayload& payload);
  /// Oldest completion that is visible in cycle `now`, else nullptr.
  const Completion* front(Cycle now) const {
    return !completions_.empty() && completions_.front().visible <= now ? &completions_.front() : nullptr;
  }
  void pop() { completions_.pop(); }
  /// First cycle in which a completion becomes visible or END_RESP is due; kNever if neither is pending.
  Cycle next_visible() const {
    return completions_.empty() ? end_cycle_ : std::min(end_cycle_, completions_.front().visible);
  }
  /// First cycle in which can_send() holds; kNever while a request phase has not ended.
  Cycle next_send() const { return requesting_ == nullptr ? free_from_ : kNever; }
  std::size_t completions() const { return completions_.size(); }
  /// Requests sent whose response has not begun yet.
  std::uint64_t outstanding() const { return outstanding_; }
  const AtPayloadPool& pool() const { return *pool_; }
  bool idle() const {
    return outstanding_ == 0 && completions_.empty() && requesting_ == nullptr && responding_ == nullptr;
  }
  /// For another launch (ClockDomain::restart()); drops completions that were not popped. An error report if a
  /// transaction is under way at the memory: it cannot be taken back.
  void restart();
  /// For a completion that is not ok(): tells who has asked for refusals, else ends the simulation with an error
  /// report.
  void report_refusal(const Completion& completion) const;

 private:
  ::tlm::tlm_sync_enum nb_transport_bw(::tlm::tlm_generic_payload& payload, ::tlm::tlm_phase& phase,
                                       sc_core::sc_time& delay);
  /// Whether the target may begin a response of this payload now; reports an error if not.
  bool may_respond(const AtPayload& payload) const;
  void end_request(const AtPayload& payload, const sc_core::sc_time& delay);
  void complete(AtPayload& payload, const sc_core::sc_time& delay);
  void begin_response(AtPayload& payload, const sc_core::sc_time& delay);
  void end_response(Cycle now);
  void make_visible(Cycle cycle) {
    if (process_ != nullptr) return process_->request(cycle);
    clock_.request(cycle);
  }

  ClockDomain& clock_;
  Alarm* process_ = nullptr;
  bool keeps_data_ = false;
  bool held_ = false;
  std::uint64_t base_ = 0;
  Refused refused_;
  std::unique_ptr<AtPayloadPool> pool_;
  const AtPayload* requesting_ = nullptr;
  Cycle free_from_ = 0;
  std::uint64_t outstanding_ = 0;
  AtPayload* responding_ = nullptr;  ///< in its response phase
  Cycle end_cycle_ = kNever;         ///< cycle in which END_RESP is sent
  std::uint64_t end_value_ = 0;      ///< time at which END_RESP takes effect
  Cycle last_visible_ = 0;
  RingQueue<Completion> completions_;
};

}  // namespace grtx::modules
