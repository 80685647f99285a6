// Signals of a Verilated block that a waveform shows below its unit.
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

/// A unit that is a Verilated block.
class RtlSignals {
 public:
  virtual const std::vector<RtlSignal>& rtl_signals() const = 0;
  /// Value of signal `index`: pins as they were at the last clock edge of cycle `now`, with valid low if there was
  /// none; registers as they are after it.
  virtual std::uint64_t rtl_value(std::size_t index, Cycle now) const = 0;

 protected:
  ~RtlSignals() = default;
};

}  // namespace grtx::sim
