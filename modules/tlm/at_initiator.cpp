#include "grtx/modules/tlm/at_initiator.h"

#include <bit>
#include <cassert>

namespace grtx::modules {

AtInitiator::AtInitiator(const char* socket_name, ClockDomain& clock)
    : socket(socket_name), clock_(clock), clock_period_(sc_core::sc_time::from_value(clock.period_fs())) {
  socket.register_nb_transport_bw(this, &AtInitiator::nb_transport_bw);
}

void AtInitiator::send(std::uint64_t address, unsigned bytes, bool write, std::uint32_t context) {
  assert(requesting_ == nullptr && std::has_single_bit(bytes) && bytes <= AtPayload::kMaxBytes);
  assert(address % bytes == 0);
  AtPayload& payload = pool_.acquire();
  payload.context = context;
  payload.sent_address = address;
  payload.set_command(write ? ::tlm::TLM_WRITE_COMMAND : ::tlm::TLM_READ_COMMAND);
  payload.set_address(address);
  payload.set_data_ptr(payload.data.data());
  payload.set_data_length(bytes);
  payload.set_streaming_width(bytes);
  payload.set_byte_enable_ptr(nullptr);
  payload.set_dmi_allowed(false);
  payload.set_response_status(::tlm::TLM_INCOMPLETE_RESPONSE);
  requesting_ = &payload;
  ++outstanding_;

  ::tlm::tlm_phase phase = tlm::BEGIN_REQ;
  sc_core::sc_time delay = clock_.ahead_of_kernel();
  switch (socket->nb_transport_fw(payload, phase, delay)) {
    case ::tlm::TLM_ACCEPTED:
      break;
    case ::tlm::TLM_UPDATED:
      end_request(payload, delay);
      if (phase == tlm::BEGIN_RESP) {
        complete(payload, delay);
        ::tlm::tlm_phase end = tlm::END_RESP;
        delay += clock_period_;
        socket->nb_transport_fw(payload, end, delay);
        payload.release();
      }
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
  AtPayload& payload = static_cast<AtPayload&>(transaction);  // only payloads of our own pool come back to us
  if (phase == tlm::END_REQ) {
    end_request(payload, delay);
    return ::tlm::TLM_ACCEPTED;
  }
  if (phase != tlm::BEGIN_RESP) return ::tlm::TLM_ACCEPTED;  // extended phases are ignored
  end_request(payload, delay);                               // BEGIN_RESP implies END_REQ
  complete(payload, delay);
  // Never TLM_COMPLETED here: legal, but it hangs DRAMSys 5.1. The target keeps a reference of its own until END_RESP.
  phase = tlm::END_RESP;
  delay += clock_period_;
  payload.release();
  return ::tlm::TLM_UPDATED;
}

void AtInitiator::end_request(const AtPayload& payload, const sc_core::sc_time& delay) {
  if (requesting_ != &payload) return;
  requesting_ = nullptr;
  free_from_ = clock_.edge_after(delay.value());
  make_visible(free_from_);
}

void AtInitiator::complete(AtPayload& payload, const sc_core::sc_time& delay) {
  assert(!payload.responded && outstanding_ > 0);
  payload.responded = true;
  --outstanding_;
  Cycle visible = clock_.edge_after(delay.value());
  // Annotated delays may overtake; the queue hands completions over in the order of their calls.
  if (!completions_.empty() && visible < last_visible_) visible = last_visible_;
  last_visible_ = visible;
  completions_.push({payload.context, payload.is_write(), payload.get_response_status() == ::tlm::TLM_OK_RESPONSE,
                     payload.sent_address, visible});
  make_visible(visible);
}

}  // namespace grtx::modules
