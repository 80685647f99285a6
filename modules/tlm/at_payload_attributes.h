// SPDX-License-Identifier: Apache-2.0
// Sets the attributes of a payload in the way common to all initiators of this project.
#pragma once

#include <algorithm>

#include "grtx/modules/tlm/at_payload_pool.h"

namespace grtx::modules {

/// bytes: at most AtPayload::kMaxBytes. A write gets zeros: the buffer may hold what the payload read in its last life.
inline void set_attributes(AtPayload& payload, std::uint64_t address, unsigned bytes, bool write) {
  payload.sent_address = address;
  payload.set_command(write ? ::tlm::TLM_WRITE_COMMAND : ::tlm::TLM_READ_COMMAND);
  payload.set_address(address);
  if (write) std::fill_n(payload.data.begin(), bytes, static_cast<unsigned char>(0));
  payload.set_data_ptr(payload.data.data());
  payload.set_data_length(bytes);
  payload.set_streaming_width(bytes);
  payload.set_byte_enable_ptr(nullptr);
  payload.set_dmi_allowed(false);
  payload.set_response_status(::tlm::TLM_INCOMPLETE_RESPONSE);
}

}  // namespace grtx::modules
