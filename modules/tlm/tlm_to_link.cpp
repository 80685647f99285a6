// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/tlm/tlm_to_link.h"

#include <algorithm>
#include <ostream>
#include <string>
#include <utility>

#include "grtx/modules/kernel/unit_fault.h"
#include "grtx/modules/tlm/functional_memory.h"
#include "grtx/modules/tlm/target_rules.h"

namespace grtx::modules {

using sc_core::sc_time;
using ::tlm::tlm_generic_payload;

TlmToLink::~TlmToLink() = default;

TlmToLink::TlmToLink(const sc_core::sc_module_name& name, const Config& config, ClockDomain& clock)
    : ClockedModule(name, clock),
      socket("socket"),
      request("request"),
      response("response"),
      config_(config),
      data_(config.data),
      slots_(config.outstanding) {
  free_all();
  socket.register_nb_transport_fw(this, &TlmToLink::nb_transport_fw);
  socket.register_b_transport(this, &TlmToLink::b_transport);
  if (!data_) {
    memory_ = std::make_unique<FunctionalMemory>();
    data_ = [this](tlm_generic_payload& payload) { return memory_->access(payload); };
  }
  socket.register_transport_dbg(this, &TlmToLink::transport_dbg);
  if (config_.dmi) socket.register_get_direct_mem_ptr(this, &TlmToLink::get_direct_mem_ptr);
}

void TlmToLink::end_of_elaboration() { response->wake(&alarm_); }

// Data stay, as those of a memory do.
void TlmToLink::restart(Caches) {
  if (!idle()) unit_fault(name(), "a restart while transactions of its initiator are inside");
  free_all();
  arrival_ = response_free_ = 0;
  transactions_ = sectors_ = refused_ = 0;
}

void TlmToLink::free_all() {
  free_.clear();
  for (unsigned i = config_.outstanding; i > 0; --i) free_.push_back(i - 1);
}

::tlm::tlm_response_status TlmToLink::check(const tlm_generic_payload& payload) {
  if (const auto refused = common_refusal(payload); refused != ::tlm::TLM_OK_RESPONSE) return refused;
  if (payload.get_data_length() == 0 || payload.get_streaming_width() < payload.get_data_length()) {
    return ::tlm::TLM_BURST_ERROR_RESPONSE;
  }
  if (!lies_below(kAddressable, payload.get_address(), payload.get_data_length())) {
    return ::tlm::TLM_ADDRESS_ERROR_RESPONSE;
  }
  return ::tlm::TLM_OK_RESPONSE;
}

bool TlmToLink::refuse(tlm_generic_payload& payload) {
  const ::tlm::tlm_response_status status = check(payload);
  if (status == ::tlm::TLM_OK_RESPONSE) return false;
  payload.set_response_status(status);
  ++refused_;
  return true;
}

::tlm::tlm_sync_enum TlmToLink::nb_transport_fw(tlm_generic_payload& payload, ::tlm::tlm_phase& phase, sc_time& delay) {
  const Cycle edge = clock_.edge_after(delay.value());
  if (phase == tlm::BEGIN_REQ) {
    if (refuse(payload)) return ::tlm::TLM_COMPLETED;
    if (arriving_ != nullptr) return reject(payload, "BEGIN_REQ before END_REQ of the previous request");
    payload.acquire();
    arriving_ = &payload;
    arrival_ = edge;
    alarm_.request(edge);
  } else if (phase == tlm::END_RESP) {
    if (responding_ != &payload) return reject(payload, "END_RESP without BEGIN_RESP");
    end_response(edge);
  }
  return ::tlm::TLM_ACCEPTED;
}

// A report may be configured not to throw; the call then changes nothing here, and the caller gets an error status.
::tlm::tlm_sync_enum TlmToLink::reject(tlm_generic_payload& payload, const char* rule) {
  SC_REPORT_ERROR("/grtx/tlm_to_link", (std::string(name()) + ": " + rule).c_str());
  payload.set_response_status(::tlm::TLM_GENERIC_ERROR_RESPONSE);
  return ::tlm::TLM_COMPLETED;
}

unsigned TlmToLink::transport_dbg(tlm_generic_payload& payload) {
  const bool inside = lies_below(kAddressable, payload.get_address(), payload.get_data_length());
  return inside && payload.get_data_ptr() != nullptr ? data_(payload) : 0;
}

/// A blocking call on the stack of its thread. Killed or reset inside, the thread leaves by an exception of the
/// kernel's, and its payload and event with it: the transaction then goes on without them, and moves no data.
class TlmToLink::BlockingCall {
 public:
  BlockingCall(TlmToLink& bridge, tlm_generic_payload& payload)
      : bridge_(bridge), slot_(bridge.enter(payload, &done_)) {}
  ~BlockingCall() {
    Transaction& transaction = bridge_.slots_[slot_];
    if (transaction.done != &done_) return;  // it has been answered
    transaction.payload = nullptr;
    transaction.done = nullptr;
  }
  BlockingCall(const BlockingCall&) = delete;
  BlockingCall& operator=(const BlockingCall&) = delete;
  const sc_core::sc_event& done() const { return done_; }

 private:
  TlmToLink& bridge_;
  sc_core::sc_event done_;
  std::uint32_t slot_;
};

void TlmToLink::b_transport(tlm_generic_payload& payload, sc_time& delay) {
  if (refuse(payload)) return;
  if (delay != sc_core::SC_ZERO_TIME) wait(delay);  // synchronises loosely timed initiators that are ahead of time
  delay = sc_core::SC_ZERO_TIME;
  while (!room()) wait(room_);
  const BlockingCall call(*this, payload);
  alarm_.request(clock_.edge_after());
  wait(call.done());
}

std::uint32_t TlmToLink::enter(tlm_generic_payload& payload, sc_core::sc_event* done) {
  const std::uint32_t slot = free_.back();
  free_.pop_back();
  const std::uint64_t first = payload.get_address() / kSectorBytes * kSectorBytes;
  const std::uint64_t last = (payload.get_address() + payload.get_data_length() - 1) / kSectorBytes * kSectorBytes;
  const std::uint64_t sectors = (last - first) / kSectorBytes + 1;
  slots_[slot] = {&payload, done, first, sectors, sectors, payload.is_write()};
  sending_.push_back(slot);
  ++inside_;
  return slot;
}

Cycle TlmToLink::tick(Cycle now) {
  take_responses(now);
  take_arrival(now);
  send_sector(now);
  begin_response(now);
  Cycle next = response->next_visible();
  if (!sending_.empty()) next = std::min(next, now + 1);
  if (arriving_ != nullptr && room()) next = std::min(next, arrival_);
  if (!answered_.empty() && responding_ == nullptr) next = std::min(next, response_free_);
  return next;
}

void TlmToLink::take_responses(Cycle now) {
  while (const MemoryResponse* arrived = response->front(now)) {
    const std::uint32_t slot = arrived->tag;
    response->pop(now);
    if (slot >= slots_.size() || slots_[slot].to_come == 0) {
      throw WrongAnswer("what is behind has answered request " + std::to_string(slot) + ", which is not under way");
    }
    Transaction& transaction = slots_[slot];
    if (--transaction.to_come > 0) continue;
    answer(transaction);
    transaction = {};
    free_.push_back(slot);
  }
}

// The payload of a blocking call whose thread was killed is gone.
void TlmToLink::answer(const Transaction& transaction) {
  if (transaction.payload == nullptr) return leave();
  tlm_generic_payload& payload = *transaction.payload;
  const bool held = data_(payload) == payload.get_data_length();
  payload.set_response_status(held ? ::tlm::TLM_OK_RESPONSE : ::tlm::TLM_ADDRESS_ERROR_RESPONSE);
  payload.set_dmi_allowed(config_.dmi != nullptr);
  if (transaction.done == nullptr) return answered_.push_back(transaction.payload);
  transaction.done->notify(clock_.ahead_of_kernel());
  leave();
}

void TlmToLink::take_arrival(Cycle now) {
  if (arriving_ == nullptr || arrival_ > now || !room()) return;
  tlm_generic_payload& payload = *std::exchange(arriving_, nullptr);
  enter(payload, nullptr);
  ::tlm::tlm_phase phase = tlm::END_REQ;
  sc_time delay = clock_.ahead_of_kernel();
  socket->nb_transport_bw(payload, phase, delay);
}

void TlmToLink::send_sector(Cycle now) {
  while (!sending_.empty() && slots_[sending_.front()].to_send == 0) sending_.pop_front();
  if (sending_.empty() || !request->can_push(now)) return;
  const std::uint32_t slot = sending_.front();
  Transaction& transaction = slots_[slot];
  MemoryRequest sector;
  sector.address = transaction.next_sector;
  sector.tag = slot;
  sector.client = config_.client;
  sector.sm = config_.sm;
  sector.region = config_.region;
  sector.write = transaction.write;
  request->push(now, sector);
  ++sectors_;
  transaction.next_sector += kSectorBytes;
  if (--transaction.to_send == 0) sending_.pop_front();
}

void TlmToLink::begin_response(Cycle now) {
  if (answered_.empty() || responding_ != nullptr || response_free_ > now) return;
  tlm_generic_payload& payload = *answered_.front();
  answered_.pop_front();
  responding_ = &payload;
  ::tlm::tlm_phase phase = tlm::BEGIN_RESP;
  sc_time delay = clock_.ahead_of_kernel();
  const ::tlm::tlm_sync_enum status = socket->nb_transport_bw(payload, phase, delay);
  const bool ended = status == ::tlm::TLM_COMPLETED || (status == ::tlm::TLM_UPDATED && phase == tlm::END_RESP);
  if (ended && responding_ != nullptr) end_response(clock_.edge_after(delay.value()));
}

void TlmToLink::end_response(Cycle free_from) {
  std::exchange(responding_, nullptr)->release();
  response_free_ = free_from;
  leave();
  if (!answered_.empty() || arriving_ != nullptr) alarm_.request(free_from);
}

void TlmToLink::leave() {
  ++transactions_;
  --inside_;
  room_.notify(clock_.ahead_of_kernel());
}

void TlmToLink::dump_state(std::ostream& out) const {
  out << name() << ": " << inside_ << " transactions inside, " << sending_.size() << " with sectors to send, "
      << answered_.size() << " answered" << (arriving_ != nullptr ? ", request waiting" : "")
      << (responding_ != nullptr ? ", response open" : "") << '\n';
}

}  // namespace grtx::modules
