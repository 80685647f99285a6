// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/tlm/at_monitor.h"

namespace grtx::modules {

using sc_core::sc_time;
using ::tlm::tlm_generic_payload;
using ::tlm::tlm_phase;
using ::tlm::tlm_sync_enum;

AtMonitor::AtMonitor(const sc_core::sc_module_name& name) : sc_module(name), target("target"), initiator("initiator") {
  target.register_nb_transport_fw(this, &AtMonitor::forward);
  target.register_b_transport(this, &AtMonitor::blocking);
  target.register_transport_dbg(this, &AtMonitor::debug);
  target.register_get_direct_mem_ptr(this, &AtMonitor::direct);
  initiator.register_nb_transport_bw(this, &AtMonitor::backward);
  initiator.register_invalidate_direct_mem_ptr(this, &AtMonitor::invalidate);
}

void AtMonitor::count_request(const tlm_generic_payload& payload, const sc_time& delay) {
  ++(payload.is_write() ? traffic_.writes : traffic_.reads);
  traffic_.bytes += payload.get_data_length();
  latency_ -= (sc_core::sc_time_stamp() + delay).value();
}

void AtMonitor::count_response(bool refused, const sc_time& delay) {
  ++traffic_.responses;
  if (refused) ++traffic_.refused;
  latency_ += (sc_core::sc_time_stamp() + delay).value();
}

// Reads the payload before the call: when the call returns, an ended transaction may be back in its pool.
tlm_sync_enum AtMonitor::forward(tlm_generic_payload& payload, tlm_phase& phase, sc_time& delay) {
  const bool begin = phase == tlm::BEGIN_REQ;
  if (begin) count_request(payload, delay);
  if (phase == tlm::END_RESP) ++ended_;
  const tlm_sync_enum status = initiator->nb_transport_fw(payload, phase, delay);
  if (!begin) return status;
  const bool completed = status == ::tlm::TLM_COMPLETED;
  if (completed) ++ended_;
  const bool responded = completed || (status == ::tlm::TLM_UPDATED && phase == tlm::BEGIN_RESP);
  if (responded) count_response(payload.is_response_error(), delay);
  return status;
}

tlm_sync_enum AtMonitor::backward(tlm_generic_payload& payload, tlm_phase& phase, sc_time& delay) {
  const bool response = phase == tlm::BEGIN_RESP;
  if (response) count_response(payload.is_response_error(), delay);
  const tlm_sync_enum status = target->nb_transport_bw(payload, phase, delay);
  if (response && (status == ::tlm::TLM_COMPLETED || (status == ::tlm::TLM_UPDATED && phase == tlm::END_RESP))) {
    ++ended_;
  }
  return status;
}

void AtMonitor::blocking(tlm_generic_payload& payload, sc_time& delay) {
  count_request(payload, delay);
  try {
    initiator->b_transport(payload, delay);
  } catch (...) {  // the calling thread is killed or reset, or the target has failed: no response will come
    count_response(true, sc_core::SC_ZERO_TIME);
    ++ended_;
    throw;
  }
  count_response(payload.is_response_error(), delay);
  ++ended_;
}

double AtMonitor::mean_latency_ns() const {
  if (traffic_.responses == 0) return 0.0;
  // Not by to_seconds(), whose last digit is another at other time resolutions since SystemC 3.
  const double fs = static_cast<double>(latency_) * (1e15 / sc_time(1, sc_core::SC_SEC).to_double());
  return fs * 1e-15 * 1e9 / static_cast<double>(traffic_.responses);
}

}  // namespace grtx::modules
