// Configuration keys that a mode refuses or does not look at: one table, by name.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "grtx/base/declare/named_enum.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {

/// How a trace is run (estimate/simulation_mode.h).
enum class SimulationMode : std::uint8_t {
  cycle,   ///< every module, cycle by cycle, in SystemC
  fast,    ///< loosely timed (estimate/fast); no waveforms, timelines or cycles by pixel
  sampled  ///< estimated from windows of the trace, which one of the others simulates (estimate/sampled)
};
constexpr auto enum_names(SimulationMode) { return names_in_order<SimulationMode>({"cycle", "fast", "sampled"}); }

/// Whether a mode can simulate the windows of a sample.
constexpr bool runs_windows(SimulationMode mode) { return mode != SimulationMode::sampled; }

/// A key that has no effect in a mode.
struct ModeKey {
  SimulationMode mode{};
  std::string_view key;
  const char* refused = nullptr;  ///< rule that another value than the default breaks; nullptr: it is ignored
};
const std::vector<ModeKey>& mode_keys();

/// What a configuration asks for that a mode does not model; an empty key: nothing.
struct Unmodelled {
  std::string key;
  const char* rule = "";
  explicit operator bool() const { return !key.empty(); }
};
/// The first key of the table, or of a unit that brings its keys along, that is set to another value than its default
/// and refused in that mode.
Unmodelled unmodelled(const GpuConfig& config, SimulationMode mode);

/// Keys that are set to another value than their default and ignored by all of these modes, in order of the table.
std::vector<std::string_view> ignored_keys(const GpuConfig& config, const std::vector<SimulationMode>& modes);

/// A key that is set, but that another key leaves without effect.
struct IdleKey {
  std::string key;
  std::string because;  ///< "dram.scheduling = fcfs"
};
/// All of them, whatever the mode, in order of the keys.
std::vector<IdleKey> idle_keys(const GpuConfig& config);

/// Lines on stderr that name what ignored_keys() and idle_keys() find, if anything. what: the mode as the user knows
/// it.
void warn_of_ignored_keys(const GpuConfig& config, const std::vector<SimulationMode>& modes, std::string_view what);

}  // namespace grtx::sim
