// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/memory/dram_port.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <ostream>
#include <string>

#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/tlm/target_rules.h"

namespace grtx::sim {

using modules::kNever;

DramPortCounters& DramPortCounters::operator+=(const DramPortCounters& other) {
  reads += other.reads;
  writes += other.writes;
  bytes += other.bytes;
  responses += other.responses;
  refused += other.refused;
  full_clocks += other.full_clocks;
  inside_clocks += other.inside_clocks;
  return *this;
}

DramPort::DramPort(const char* name, const Config& config, modules::ClockDomain& clock, modules::Alarm& alarm)
    : socket(name), config_(config), clock_(clock), alarm_(alarm) {
  socket.register_nb_transport_fw(this, &DramPort::nb_transport_fw);
  socket.register_b_transport(this, &DramPort::b_transport);
}

::tlm::tlm_response_status DramPort::check(const ::tlm::tlm_generic_payload& payload) const {
  const std::uint64_t bytes = payload.get_data_length();
  if (const auto refused = modules::common_refusal(payload); refused != ::tlm::TLM_OK_RESPONSE) return refused;
  if (!std::has_single_bit(bytes) || bytes > config_.longest || payload.get_streaming_width() < bytes) {
    return ::tlm::TLM_BURST_ERROR_RESPONSE;
  }
  if (payload.get_address() % bytes != 0) return ::tlm::TLM_ADDRESS_ERROR_RESPONSE;
  const std::uint64_t limit = config_.bytes != 0 ? config_.bytes : ~std::uint64_t{0};
  if (!modules::lies_below(limit, payload.get_address(), bytes)) return ::tlm::TLM_ADDRESS_ERROR_RESPONSE;
  return ::tlm::TLM_OK_RESPONSE;
}

::tlm::tlm_sync_enum DramPort::nb_transport_fw(::tlm::tlm_generic_payload& payload, ::tlm::tlm_phase& phase,
                                               sc_core::sc_time& delay) {
  const Cycle edge = clock_.edge_after(delay.value());
  if (phase == tlm::BEGIN_REQ) {
    if (arriving_ != nullptr) return reject(payload, "BEGIN_REQ before END_REQ of the previous request");
    payload.acquire();
    arriving_ = &payload;
    arrival_ = edge;
    ++outstanding_;
  } else if (phase == tlm::END_RESP) {
    if (responding_ != &payload) return reject(payload, "END_RESP without BEGIN_RESP");
    responding_ = nullptr;
    response_free_ = edge;
    payload.release();
  } else {
    return ::tlm::TLM_ACCEPTED;  // extended phases are ignored
  }
  alarm_.request(edge);
  return ::tlm::TLM_ACCEPTED;
}

// A report may be configured not to throw; the call then changes nothing here, and the caller gets an error status.
::tlm::tlm_sync_enum DramPort::reject(::tlm::tlm_generic_payload& payload, const char* rule) const {
  SC_REPORT_ERROR("/grtx/dram", (std::string(socket.name()) + ": " + rule).c_str());
  payload.set_response_status(::tlm::TLM_GENERIC_ERROR_RESPONSE);
  return ::tlm::TLM_COMPLETED;
}

// Loosely timed accesses are for warm-up and debugging and do not reach the simulator.
void DramPort::b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time& delay) {
  payload.set_response_status(check(payload));
  modules::read_zeros(payload);
  delay += sc_core::sc_time::from_value(config_.fixed_latency * clock_.period_value());
}

const ::tlm::tlm_generic_payload* DramPort::arrived(Cycle now) {
  if (arriving_ == nullptr || arrival_ > now) return nullptr;
  const ::tlm::tlm_response_status status = check(*arriving_);
  if (status == ::tlm::TLM_OK_RESPONSE) return arriving_;
  ++counters_.refused;
  ::tlm::tlm_generic_payload& payload = end_request();
  payload.set_response_status(status);
  responses_.push({&payload, now + config_.fixed_latency});
  return nullptr;
}

::tlm::tlm_generic_payload& DramPort::end_request() {
  ::tlm::tlm_generic_payload& payload = *arriving_;
  arriving_ = nullptr;
  ::tlm::tlm_phase phase = tlm::END_REQ;
  sc_core::sc_time delay = clock_.ahead_of_kernel();
  socket->nb_transport_bw(payload, phase, delay);
  return payload;
}

void DramPort::count_inside(Cycle now) {
  counters_.inside_clocks += inside_ * (now - counted_);
  counted_ = now;
}

::tlm::tlm_generic_payload& DramPort::accept(Cycle now) {
  assert(arriving_ != nullptr && arrival_ <= now);
  counters_.full_clocks += now - arrival_;
  count_inside(now);
  ++inside_;
  ++(arriving_->is_write() ? counters_.writes : counters_.reads);
  counters_.bytes += arriving_->get_data_length();
  return end_request();
}

void DramPort::complete(::tlm::tlm_generic_payload& payload, Cycle now, bool ok) {
  assert(inside_ > 0);
  count_inside(now);
  --inside_;
  payload.set_response_status(ok ? ::tlm::TLM_OK_RESPONSE : ::tlm::TLM_GENERIC_ERROR_RESPONSE);
  responses_.push({&payload, now + config_.fixed_latency});
}

Cycle DramPort::step(Cycle now) {
  if (!responses_.empty() && responses_.front().due <= now && responding_ == nullptr && response_free_ <= now) {
    ::tlm::tlm_generic_payload& payload = *responses_.front().payload;
    responses_.pop();
    responding_ = &payload;
    modules::read_zeros(payload);
    ::tlm::tlm_phase phase = tlm::BEGIN_RESP;
    sc_core::sc_time delay = clock_.ahead_of_kernel();
    const ::tlm::tlm_sync_enum status = socket->nb_transport_bw(payload, phase, delay);
    ++counters_.responses;
    --outstanding_;
    const bool ended = status == ::tlm::TLM_COMPLETED || (status == ::tlm::TLM_UPDATED && phase == tlm::END_RESP);
    if (ended && responding_ == &payload) {  // else END_RESP comes by nb_transport_fw
      responding_ = nullptr;
      response_free_ = clock_.edge_after(delay.value());
      payload.release();
    }
  }
  Cycle due = arriving_ != nullptr && arrival_ > now ? arrival_ : kNever;
  if (!responses_.empty() && responding_ == nullptr) {
    due = std::min(due, std::max({responses_.front().due, response_free_, now + 1}));
  }
  return due;
}

void DramPort::dump_state(std::ostream& out) const {
  out << socket.name() << ": outstanding " << outstanding_ << ", taken " << inside_ << ", responses "
      << responses_.size() << (arriving_ != nullptr ? ", request waiting" : "")
      << (responding_ != nullptr ? ", response open" : "") << '\n';
}

}  // namespace grtx::sim
