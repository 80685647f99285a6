// SPDX-License-Identifier: Apache-2.0
// A memory that holds data, and that others have filled: behind all L2 slices of a GPU.
#pragma once

#include <tlm_utils/simple_target_socket.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "grtx/rtl_tlm/gpu/monitored_memory.h"

namespace grtx::sim::test {

/// No byte is 0, and a sector's are unlike those of any other near it.
inline unsigned char others_byte(std::uint64_t address) {
  return static_cast<unsigned char>((address * 0x9E3779B97F4A7C15u >> 56) | 1);
}

/// All slices' memory, filled by somebody else beyond the GPU's end, too; answers at once.
struct SharedContents final : sc_core::sc_module {
  SharedContents(const sc_core::sc_module_name& name, Gpu& gpu)
      : sc_module(name), sockets("socket", gpu.dram.size()), bytes(gpu.memory_bytes() + (1 << 16)) {
    for (std::uint64_t i = 0; i < bytes.size(); ++i) bytes[i] = others_byte(i);
    for (unsigned i = 0; i < sockets.size(); ++i) {
      sockets[i].register_nb_transport_fw(this, &SharedContents::nb_transport_fw, static_cast<int>(i));
      sockets[i].register_transport_dbg(this, &SharedContents::transport_dbg, static_cast<int>(i));
    }
  }
  ::tlm::tlm_sync_enum nb_transport_fw(int id, ::tlm::tlm_generic_payload& payload, ::tlm::tlm_phase& phase,
                                       sc_core::sc_time& delay) {
    if (phase != ::tlm::BEGIN_REQ) return ::tlm::TLM_ACCEPTED;
    const bool held = transport_dbg(id, payload) == payload.get_data_length();
    payload.set_response_status(held ? ::tlm::TLM_OK_RESPONSE : ::tlm::TLM_ADDRESS_ERROR_RESPONSE);
    delay += sc_core::sc_time(100, sc_core::SC_NS);
    return ::tlm::TLM_COMPLETED;
  }
  unsigned transport_dbg(int, ::tlm::tlm_generic_payload& payload) {
    const std::uint64_t first = payload.get_address();
    const unsigned length = payload.get_data_length();
    if (first + length > bytes.size()) return 0;
    if (payload.is_read()) std::copy_n(&bytes[first], length, payload.get_data_ptr());
    if (payload.is_write()) std::copy_n(payload.get_data_ptr(), length, &bytes[first]);
    return length;
  }
  sc_core::sc_vector<tlm_utils::simple_target_socket_tagged<SharedContents, 32>> sockets;
  std::vector<unsigned char> bytes;
};

class SharedMemory final : public MonitoredMemory {
 public:
  explicit SharedMemory(Gpu& gpu) : MonitoredMemory(gpu, "shared", true), contents("contents", gpu) {
    for (unsigned i = 0; i < channels(); ++i) socket(i).bind(contents.sockets[i]);
  }
  SharedContents contents;
};

}  // namespace grtx::sim::test
