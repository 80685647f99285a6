// SPDX-License-Identifier: Apache-2.0
// Counts the transactions on a 32-bit TLM-2.0 connection, approximately timed or blocking. Inserted between an
// initiator and its target; changes nothing: debug and direct memory access pass, uncounted. Costs a few additions per
// call.
#pragma once

#include <tlm_utils/simple_initiator_socket.h>
#include <tlm_utils/simple_target_socket.h>

#include <cstdint>
#include <systemc>
#include <tlm>

#include "grtx/modules/tlm/memory_traffic.h"

namespace grtx::modules {

class AtMonitor final : public sc_core::sc_module {
 public:
  explicit AtMonitor(const sc_core::sc_module_name& name);

  tlm_utils::simple_target_socket<AtMonitor, 32> target;        ///< bind the initiator to this
  tlm_utils::simple_initiator_socket<AtMonitor, 32> initiator;  ///< bind this to the target

  const MemoryTraffic& traffic() const { return traffic_; }
  /// Requests begun and not answered yet. A blocking call whose thread is killed or reset inside counts as refused.
  std::uint64_t outstanding() const { return traffic_.reads + traffic_.writes - traffic_.responses; }
  /// Whether all transactions have ended, including their response phases.
  bool idle() const { return ended_ == traffic_.reads + traffic_.writes; }
  /// Resets all counts; requires idle().
  void restart() {
    traffic_ = {};
    ended_ = latency_ = 0;
  }
  /// Mean of (begin of response - begin of request); exact when nothing is outstanding.
  double mean_latency_ns() const;

 private:
  ::tlm::tlm_sync_enum forward(::tlm::tlm_generic_payload& payload, ::tlm::tlm_phase& phase, sc_core::sc_time& delay);
  ::tlm::tlm_sync_enum backward(::tlm::tlm_generic_payload& payload, ::tlm::tlm_phase& phase, sc_core::sc_time& delay);
  void blocking(::tlm::tlm_generic_payload& payload, sc_core::sc_time& delay);
  unsigned debug(::tlm::tlm_generic_payload& payload) { return initiator->transport_dbg(payload); }
  bool direct(::tlm::tlm_generic_payload& payload, ::tlm::tlm_dmi& dmi) {
    return initiator->get_direct_mem_ptr(payload, dmi);
  }
  void invalidate(sc_dt::uint64 begin, sc_dt::uint64 end) { target->invalidate_direct_mem_ptr(begin, end); }
  void count_request(const ::tlm::tlm_generic_payload& payload, const sc_core::sc_time& delay);
  void count_response(bool refused, const sc_core::sc_time& delay);

  MemoryTraffic traffic_;
  std::uint64_t ended_ = 0;
  std::uint64_t latency_ = 0;  ///< sum of response times - sum of request times, in kernel time units, modulo 2^64
};

}  // namespace grtx::modules
