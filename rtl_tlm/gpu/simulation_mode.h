// The ways to run a trace, by name.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/base/declare/named_enum.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {

/// All of them are the same machine.
enum class SimulationMode : std::uint8_t {
  cycle,    ///< every event takes time
  sampled,  ///< of each lane's events one in sample.stride takes time (estimate/sampled_simulation.h)
  windows   ///< every event of some windows of the trace takes time (estimate/windows)
};
constexpr auto enum_names(SimulationMode) { return names_in_order<SimulationMode>({"cycle", "sampled", "windows"}); }

/// What a mode that is gone was called, and what to say of it; "" for any other name.
std::string gone_mode(const std::string& name);

/// A key that a mode refuses, and the rule; an empty key: none.
struct Unmodelled {
  std::string key;
  std::string rule;
  explicit operator bool() const { return !key.empty(); }
};
/// The first unit that is written in SystemVerilog, in a mode that does not run all of the trace: it has one entry, and
/// that one takes time.
Unmodelled unmodelled(const GpuConfig& config, SimulationMode mode);

}  // namespace grtx::sim
