// SPDX-License-Identifier: Apache-2.0
// What windows mode does not do, and in which words it says so. It refuses keys, options and traces that it cannot
// serve, and leaves to cycle mode the traces of which windows would not be worth it.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/rtl_tlm/estimate/windows/window_simulation.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"
#include "grtx/rtl_tlm/run/simulation.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

/// A key that a mode refuses, and why; an empty key: none.
struct Unmodelled {
  std::string key;
  std::string rule;
  explicit operator bool() const { return !key.empty(); }
};
/// In windows mode the first key that selects a unit in SystemVerilog, which is compared on whole traces, or a DRAM
/// model other than the built-in one.
Unmodelled unmodelled(const GpuConfig& config, SimulationMode mode);
/// Throws Error for such a key.
void check_mode(const GpuConfig& config, SimulationMode mode);
/// Throws Error for options of another mode: waveforms, timelines and heat maps need cycle mode; windows cannot start
/// from warm caches.
void check_mode(const SimulationOptions& options, bool heat_maps, SimulationMode mode);
/// Throws Error for --latency, of which the cycle of each read is needed.
[[noreturn]] void refuse_latency(const std::string& command);
/// Throws Error if frames that follow each other are to find warm caches.
void check_mode_of_frames(SimulationMode mode);

/// Throws Error for options out of range.
void check_windows(const WindowOptions& options);
/// Throws Error for a sequence of frames.
void check_windows(const traces::Reader& reader);

/// Why the whole trace is simulated instead; empty: it is not.
std::string reason_for_whole(const traces::Reader& reader, const GpuConfig& config, const WindowOptions& options);
/// Why the whole trace is simulated instead of windows that are `share` of it, for a narrower interval; empty: it is
/// not.
std::string reason_for_whole(double share);

/// Node visits that take about five minutes of one core in cycle mode.
inline constexpr std::uint64_t kManyVisits = 100'000'000;
/// Whether a run that names no mode should take windows: nothing is refused, and the trace has at least `many` node
/// visits.
bool windows_pay(const traces::Reader& reader, const GpuConfig& config, const WindowOptions& options,
                 std::uint64_t many = kManyVisits);

}  // namespace grtx::sim
