// SPDX-License-Identifier: Apache-2.0
// What a plain L2 slice and its DRAM channel tell each other, in the times of the TLM-2.0 phases: docs/model/tlm.md.
#pragma once

#include <deque>
#include <optional>
#include <utility>

#include "rtl_tlm/plain/clocks.h"
#include "rtl_tlm/plain/messages.h"

namespace grtx::sim::plain {

struct DramSocket {
  std::optional<std::pair<Femtoseconds, Access>> request;  ///< BEGIN_REQ without END_REQ
  Femtoseconds request_ended = 0;                          ///< time of the last END_REQ; meaningful when used
  bool used = false;
  std::deque<std::pair<Femtoseconds, Access>> responses;  ///< BEGIN_RESP, not taken by the L2 yet
  Femtoseconds response_ends = 0;                         ///< END_RESP of the last one takes effect
  bool response_used = false;                             ///< there was one
};

}  // namespace grtx::sim::plain
