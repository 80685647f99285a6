// SPDX-License-Identifier: Apache-2.0
// Signals of a Verilated block, shown below its unit in waveforms.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "grtx/base/strong.h"

namespace grtx::sim {

struct RtlSignal {
  std::string name;
  unsigned width = 1;  ///< bits, at most 64
};

/// Additional base class of a unit that is a Verilated block.
class RtlSignals {
 public:
  virtual const std::vector<RtlSignal>& rtl_signals() const = 0;
  /// Value of signal `index`: for pins at the last clock edge of cycle `now`, with valid low if there was no edge; for
  /// registers after that edge.
  virtual std::uint64_t rtl_value(std::size_t index, Cycle now) const = 0;

 protected:
  ~RtlSignals() = default;
};

}  // namespace grtx::sim
