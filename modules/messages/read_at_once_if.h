// SPDX-License-Identifier: Apache-2.0
// The L1 as a unit without a link before it sees it: asked in a cycle, it says in that cycle whether it holds a sector.
#pragma once

#include <cstdint>
#include <systemc>

#include "grtx/base/strong.h"
#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

enum class ReadAtOnce : std::uint8_t {
  hit,        ///< it holds the sector: the caller has the data, and no response follows
  under_way,  ///< the response comes through the port
  refused,    ///< no place for a miss: to be asked again
};

/// For the first client of the L1 (rt_node), which does not send requests through its link then.
class read_at_once_if : public virtual sc_core::sc_interface {
 public:
  /// Reads a sector in cycle `now`, behind all that the L1 does in that cycle by itself, whichever of the two modules
  /// is called first. Takes no bank.
  virtual ReadAtOnce read_at_once(Cycle now, const MemoryRequest& sector) = 0;
};

using OptionalReadAtOnce = sc_core::sc_port<read_at_once_if, 1, sc_core::SC_ZERO_OR_MORE_BOUND>;

}  // namespace grtx::modules
