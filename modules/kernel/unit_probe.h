// SPDX-License-Identifier: Apache-2.0
// Waveform signals that a unit declares itself, below its name in the hierarchy.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "grtx/base/strong.h"

namespace grtx::modules {

/// State of a unit: busy, or waiting because something waits at or for it.
enum class UnitState : std::uint8_t { idle, busy, waiting };
inline std::uint64_t state_of(bool waiting, bool busy) {
  return static_cast<std::uint64_t>(waiting ? UnitState::waiting : busy ? UnitState::busy : UnitState::idle);
}

/// A value for waveforms, read after each core cycle.
struct UnitProbe {
  std::string name;  ///< relative to the unit's name
  unsigned width = 32;
  std::function<std::uint64_t()> value;
  std::function<std::uint64_t(Cycle now)> value_in = {};  ///< in place of `value`, if the cycle matters
  bool detail = false;                                    ///< only in waveforms with all signals
  bool is_state = false;                                  ///< a UnitState, which viewers show by its name

  std::uint64_t at(Cycle now) const { return value_in ? value_in(now) : value(); }
};

/// Bits of probes that count, and of those of queues.
inline constexpr unsigned kCounterBits = 48, kLevelBits = 16;

/// Additional base class of a unit with own signals.
class Probed {
 public:
  /// Called once, before the simulation starts.
  virtual std::vector<UnitProbe> probes() const = 0;

 protected:
  ~Probed() = default;
};

}  // namespace grtx::modules
