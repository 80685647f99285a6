// SPDX-License-Identifier: Apache-2.0
// Rules that all targets of the project share: payloads that every target refuses, and the answer of a target without
// data.
#pragma once

#include <algorithm>
#include <tlm>

namespace grtx::modules {

/// TLM_OK_RESPONSE, or the status with which every target refuses the payload: no command, byte enables, no data
/// pointer. Length and address are the target's own rules.
inline ::tlm::tlm_response_status common_refusal(const ::tlm::tlm_generic_payload& payload) {
  if (payload.get_command() == ::tlm::TLM_IGNORE_COMMAND) return ::tlm::TLM_COMMAND_ERROR_RESPONSE;
  if (payload.get_byte_enable_ptr() != nullptr) return ::tlm::TLM_BYTE_ENABLE_ERROR_RESPONSE;
  if (payload.get_data_ptr() == nullptr) return ::tlm::TLM_GENERIC_ERROR_RESPONSE;
  return ::tlm::TLM_OK_RESPONSE;
}

/// For targets without data, before the response: a read that is answered with TLM_OK_RESPONSE reads zeros, never what
/// was in the initiator's buffer.
inline void read_zeros(const ::tlm::tlm_generic_payload& payload) {
  if (payload.is_read() && payload.is_response_ok()) {
    std::fill_n(payload.get_data_ptr(), payload.get_data_length(), static_cast<unsigned char>(0));
  }
}

}  // namespace grtx::modules
