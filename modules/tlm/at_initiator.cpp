// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/tlm/at_initiator.h"

#include <bit>
#include <cassert>
#include <sstream>
#include <string>
#include <utility>

#include "grtx/modules/kernel/unit_fault.h"
#include "grtx/modules/tlm/at_payload_attributes.h"
#include "grtx/modules/tlm/at_payload_pool.h"

namespace grtx::modules {
namespace {

const char* status_name(::tlm::tlm_response_status status) {
  switch (status) {
    case ::tlm::TLM_OK_RESPONSE:
      return "TLM_OK_RESPONSE";
    case ::tlm::TLM_INCOMPLETE_RESPONSE:
      return "TLM_INCOMPLETE_RESPONSE";
    case ::tlm::TLM_GENERIC_ERROR_RESPONSE:
      return "TLM_GENERIC_ERROR_RESPONSE";
    case ::tlm::TLM_ADDRESS_ERROR_RESPONSE:
      return "TLM_ADDRESS_ERROR_RESPONSE";
    case ::tlm::TLM_COMMAND_ERROR_RESPONSE:
      return "TLM_COMMAND_ERROR_RESPONSE";
    case ::tlm::TLM_BURST_ERROR_RESPONSE:
      return "TLM_BURST_ERROR_RESPONSE";
    case ::tlm::TLM_BYTE_ENABLE_ERROR_RESPONSE:
      return "TLM_BYTE_ENABLE_ERROR_RESPONSE";
  }
  return "an unknown status";
}

}  // namespace

AtInitiator::~AtInitiator() = default;

AtInitiator::AtInitiator(const char* socket_name, ClockDomain& clock)
    : socket(socket_name), clock_(clock), pool_(std::make_unique<AtPayloadPool>()) {
  socket.register_nb_transport_bw(this, &AtInitiator::nb_transport_bw);
}

void AtInitiator::restart() {
  if (outstanding_ != 0 || requesting_ != nullptr || responding_ != nullptr) {
    unit_fault(socket.name(), "a restart while the memory has requests");
  }
  while (!completions_.empty()) completions_.pop();
  free_from_ = last_visible_ = 0;
  held_ = false;
}

void AtInitiator::fill(AtPayload& payload) {
  payload.set_command(::tlm::TLM_READ_COMMAND);
  if (socket->transport_dbg(payload) != payload.get_data_length()) payload.data.fill(0);
  payload.set_command(::tlm::TLM_WRITE_COMMAND);
  payload.set_response_status(::tlm::TLM_INCOMPLETE_RESPONSE);
}

void AtInitiator::send(std::uint64_t address, unsigned bytes, bool write, std::uint32_t context, RequestOrigin origin) {
  assert(requesting_ == nullptr && std::has_single_bit(bytes) && bytes <= AtPayload::kMaxBytes);
  assert(address % bytes == 0);
  update(clock_.cycle());  // END_RESP of this cycle first, since the target may respond within the call below
  AtPayload& payload = pool_->acquire();
  payload.context = context;
  payload.origin.origin = origin;
  set_attributes(payload, address + base_, bytes, write);
  if (keeps_data_ && write) fill(payload);
  requesting_ = &payload;
  ++outstanding_;

  ::tlm::tlm_phase phase = tlm::BEGIN_REQ;
  sc_core::sc_time delay = clock_.ahead_of_kernel();
  switch (socket->nb_transport_fw(payload, phase, delay)) {
    case ::tlm::TLM_ACCEPTED:
      break;
    case ::tlm::TLM_UPDATED:
      end_request(payload, delay);
      if (phase == tlm::BEGIN_RESP) begin_response(payload, delay);
      break;
    case ::tlm::TLM_COMPLETED:
      end_request(payload, delay);
      complete(payload, delay);
      payload.release();
      break;
  }
}

::tlm::tlm_sync_enum AtInitiator::nb_transport_bw(::tlm::tlm_generic_payload& transaction, ::tlm::tlm_phase& phase,
                                                  sc_core::sc_time& delay) {
  AtPayload& payload = static_cast<AtPayload&>(transaction);  // the target only returns payloads of our pool
  if (phase == tlm::END_REQ) {
    end_request(payload, delay);
    return ::tlm::TLM_ACCEPTED;
  }
  if (phase != tlm::BEGIN_RESP) return ::tlm::TLM_ACCEPTED;  // extended phases are ignored
  end_request(payload, delay);                               // BEGIN_RESP implies END_REQ
  begin_response(payload, delay);
  return ::tlm::TLM_ACCEPTED;
}

// Reports may be configured not to throw; a response out of turn is then as if it had not been sent.
bool AtInitiator::may_respond(const AtPayload& payload) const {
  const char* const broken = payload.responded        ? "a second response of a request"
                             : responding_ != nullptr ? "BEGIN_RESP before END_RESP of the previous response"
                                                      : nullptr;
  if (broken != nullptr) SC_REPORT_ERROR(kReport, (std::string(socket.name()) + ": " + broken).c_str());
  return broken == nullptr;
}

void AtInitiator::begin_response(AtPayload& payload, const sc_core::sc_time& delay) {
  if (!may_respond(payload)) return;
  complete(payload, delay);
  responding_ = &payload;
  end_cycle_ = clock_.edge_after(delay.value());
  end_value_ = clock_.now_value() - clock_.ahead_of_kernel().value() + delay.value() + clock_.period_value();
  make_visible(end_cycle_);
}

// Called at the first edge after BEGIN_RESP, at most one clock after it; the rest of that clock is annotated as delay.
void AtInitiator::end_response(Cycle now) {
  AtPayload& payload = *std::exchange(responding_, nullptr);
  end_cycle_ = kNever;
  ::tlm::tlm_phase phase = tlm::END_RESP;
  sc_core::sc_time delay = clock_.ahead_of_kernel(end_value_ - clock_.time_value(now));
  socket->nb_transport_fw(payload, phase, delay);
  payload.release();
}

void AtInitiator::report_refusal(const Completion& completion) const {
  std::ostringstream text;
  const std::uint64_t address = completion.address + base_;
  text << socket.name() << ": address 0x" << std::hex << address << ": the memory answered a "
       << (completion.write ? "write" : "read") << " with " << status_name(completion.status);
  if (refused_) return refused_(address, text.str());
  SC_REPORT_ERROR(kReport, text.str().c_str());
}

void AtInitiator::end_request(const AtPayload& payload, const sc_core::sc_time& delay) {
  if (requesting_ != &payload) return;
  requesting_ = nullptr;
  if (held_) return;
  free_from_ = clock_.edge_after(delay.value());
  make_visible(free_from_);
}

void AtInitiator::complete(AtPayload& payload, const sc_core::sc_time& delay) {
  assert(outstanding_ > 0);
  payload.responded = true;
  --outstanding_;
  Cycle visible = clock_.edge_after(delay.value());
  // A call with a shorter annotated delay may overtake an earlier one; completions stay in the order of the calls.
  if (!completions_.empty() && visible < last_visible_) visible = last_visible_;
  last_visible_ = visible;
  completions_.push(
      {payload.context, payload.is_write(), payload.get_response_status(), payload.sent_address - base_, visible});
  make_visible(visible);
}

}  // namespace grtx::modules
