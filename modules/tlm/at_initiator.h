// The initiator side of the TLM-2.0 AT base protocol that an L2 slice uses towards its DRAM channel. Any base-protocol
// target with a 32-bit socket fits: the built-in Dram or an external DRAM simulator. IEEE 1666-2011, clauses 14 and 15.
#pragma once

#include <tlm_utils/simple_initiator_socket.h>
#include <algorithm>
#include <cstdint>
#include <tlm>

#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/kernel/ring_queue.h"
#include "grtx/modules/tlm/at_payload_pool.h"

namespace grtx::modules {

/// A member of a clocked module, which calls update() first in each of its ticks. One request is in its request phase
/// at a time: withheld END_REQ is the back-pressure. Responses are always taken, in any order. BEGIN_RESP is answered
/// with TLM_ACCEPTED, and END_RESP is a forward call that takes effect one clock later: targets with a time grid of
/// their own round what calls them, but not what they are returned (DRAMSys 5.1). Whatever arrives at time t is seen by
/// the module at its first edge after t, and that edge is booked in the clock domain.
class AtInitiator final {
 public:
  struct Completion {
    std::uint32_t context = 0;
    bool write = false;
    ::tlm::tlm_response_status status = ::tlm::TLM_INCOMPLETE_RESPONSE;
    std::uint64_t address = 0;  ///< as sent
    Cycle visible = 0;
    bool ok() const { return status == ::tlm::TLM_OK_RESPONSE; }
  };
  /// Type of the kernel's report on what the memory did wrong; its text is "socket: place: rule".
  static constexpr const char* kReport = "/grtx/memory";

  AtInitiator(const char* socket_name, ClockDomain& clock);
  /// The present cycle: sends the END_RESP that is due.
  void update(Cycle now) {
    if (end_cycle_ <= now) end_response(now);
  }
  /// The alarm of the module's process, which is then set for what arrives; without one the domain ticks.
  void wake(Alarm* process) { process_ = process; }

  tlm_utils::simple_initiator_socket<AtInitiator, 32> socket;

  /// The request phase of the last request has ended, as seen at `now`.
  bool can_send(Cycle now) const { return requesting_ == nullptr && free_from_ <= now; }
  /// bytes: a power of two up to AtPayload::kMaxBytes; address: a multiple of it; context: returned with the
  /// completion; origin: for whom, to targets that ask. What is read is dropped, and what is written is 0, but for what
  /// keep_data() says.
  void send(std::uint64_t address, unsigned bytes, bool write, std::uint32_t context, RequestOrigin origin = {});
  /// The memory belongs to others, too: writes carry what it holds already, which its transport_dbg tells.
  void keep_data() { keeps_data_ = true; }
  /// Before a write is sent: gives it that data.
  void fill(AtPayload& payload);
  /// Oldest completion that has arrived by `now`, else nullptr.
  const Completion* front(Cycle now) const {
    return !completions_.empty() && completions_.front().visible <= now ? &completions_.front() : nullptr;
  }
  void pop() { completions_.pop(); }
  /// Cycle in which the oldest completion becomes visible, or END_RESP is due; kNever when neither is under way.
  Cycle next_visible() const {
    return completions_.empty() ? end_cycle_ : std::min(end_cycle_, completions_.front().visible);
  }
  /// First cycle in which can_send() holds, as far as is known; kNever while a request phase has not ended.
  Cycle next_send() const { return requesting_ == nullptr ? free_from_ : kNever; }
  std::size_t completions() const { return completions_.size(); }
  /// Requests sent whose response has not begun.
  std::uint64_t outstanding() const { return outstanding_; }
  const AtPayloadPool& pool() const { return pool_; }
  bool idle() const {
    return outstanding_ == 0 && completions_.empty() && requesting_ == nullptr && responding_ == nullptr;
  }
  /// The clock begins anew (ClockDomain::restart()).
  void restart();
  /// Ends the simulation with a report on a completion that is not ok().
  void report_refusal(const Completion& completion) const;

 private:
  ::tlm::tlm_sync_enum nb_transport_bw(::tlm::tlm_generic_payload& payload, ::tlm::tlm_phase& phase,
                                       sc_core::sc_time& delay);
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
  AtPayloadPool pool_;
  const AtPayload* requesting_ = nullptr;
  Cycle free_from_ = 0;
  std::uint64_t outstanding_ = 0;
  AtPayload* responding_ = nullptr;  ///< in its response phase
  Cycle end_cycle_ = kNever;         ///< in which its END_RESP is sent
  std::uint64_t end_fs_ = 0;         ///< time at which it takes effect
  Cycle last_visible_ = 0;
  RingQueue<Completion> completions_;
};

}  // namespace grtx::modules
