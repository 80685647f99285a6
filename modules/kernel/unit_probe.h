// SPDX-License-Identifier: Apache-2.0
// Waveform signals that a unit declares itself. The signals of the standard units are in rtl_tlm/observe.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace grtx::modules {

/// A value for waveforms, read after each core cycle.
struct UnitProbe {
  std::string name;  ///< relative to the unit's name
  unsigned width = 32;
  std::function<std::uint64_t()> value;
};

/// Additional base class of a unit with own signals, which appear below its name in the hierarchy.
class Probed {
 public:
  /// Called once, before the simulation starts.
  virtual std::vector<UnitProbe> probes() const = 0;

 protected:
  ~Probed() = default;
};

}  // namespace grtx::modules
