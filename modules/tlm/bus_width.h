// SPDX-License-Identifier: Apache-2.0
// Connects TLM-2.0 sockets of different bus widths. The width is only part of the socket type; calls are passed on
// unchanged, without delay. For sockets of other widths than the 32 bits of this project's bridges and GPU. No
// hardware.
#pragma once

#include <tlm_utils/simple_initiator_socket.h>
#include <tlm_utils/simple_target_socket.h>

#include <systemc>
#include <tlm>

namespace grtx::modules {

template <unsigned FromBits, unsigned ToBits>
class BusWidth final : public sc_core::sc_module {
 public:
  explicit BusWidth(const sc_core::sc_module_name& name) : sc_module(name), from("from"), to("to") {
    from.register_nb_transport_fw(this, &BusWidth::nb_transport_fw);
    from.register_b_transport(this, &BusWidth::b_transport);
    from.register_transport_dbg(this, &BusWidth::transport_dbg);
    from.register_get_direct_mem_ptr(this, &BusWidth::get_direct_mem_ptr);
    to.register_nb_transport_bw(this, &BusWidth::nb_transport_bw);
    to.register_invalidate_direct_mem_ptr(this, &BusWidth::invalidate_direct_mem_ptr);
  }

  tlm_utils::simple_target_socket<BusWidth, FromBits> from;  ///< bind the initiator to this
  tlm_utils::simple_initiator_socket<BusWidth, ToBits> to;   ///< bind this to the target

 private:
  using Payload = ::tlm::tlm_generic_payload;

  ::tlm::tlm_sync_enum nb_transport_fw(Payload& payload, ::tlm::tlm_phase& phase, sc_core::sc_time& delay) {
    return to->nb_transport_fw(payload, phase, delay);
  }
  void b_transport(Payload& payload, sc_core::sc_time& delay) { to->b_transport(payload, delay); }
  unsigned transport_dbg(Payload& payload) { return to->transport_dbg(payload); }
  bool get_direct_mem_ptr(Payload& payload, ::tlm::tlm_dmi& dmi) { return to->get_direct_mem_ptr(payload, dmi); }
  ::tlm::tlm_sync_enum nb_transport_bw(Payload& payload, ::tlm::tlm_phase& phase, sc_core::sc_time& delay) {
    return from->nb_transport_bw(payload, phase, delay);
  }
  void invalidate_direct_mem_ptr(sc_dt::uint64 begin, sc_dt::uint64 end) {
    from->invalidate_direct_mem_ptr(begin, end);
  }
};

}  // namespace grtx::modules
