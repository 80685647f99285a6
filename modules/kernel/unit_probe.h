// Signals that a unit brings along. Those of the units that every machine has are in rtl_tlm/observe.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace grtx::modules {

/// A value for waveforms, read after each core cycle.
struct UnitProbe {
  std::string name;  ///< below the unit's
  unsigned width = 32;
  std::function<std::uint64_t()> value;
};

/// Derive a unit from this as well: its signals appear below its name in the hierarchy.
class Probed {
 public:
  /// Asked for once, before the simulation starts.
  virtual std::vector<UnitProbe> probes() const = 0;

 protected:
  ~Probed() = default;
};

}  // namespace grtx::modules
