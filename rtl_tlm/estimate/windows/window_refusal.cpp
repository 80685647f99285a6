// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/estimate/windows/window_refusal.h"

#include <fmt/format.h>

#include <utility>

#include "grtx/base/error.h"
#include "grtx/base/json.h"
#include "grtx/rtl_tlm/estimate/windows/window_plan.h"

namespace grtx::sim {
namespace {

constexpr const char* kWindowsMode = "windows mode";

bool is_sequence(const traces::Reader& reader) { return !reader.header().frame_groups.empty(); }

/// Why windows cannot represent the trace on this machine; empty: they can.
std::string unsuited(const traces::Reader& reader, const GpuConfig& config, const WindowOptions& options) {
  if (reader.header().colour == traces::ColourPer::frame) return "each window would make its colours again";
  const std::uint64_t groups = reader.group_count();
  const std::uint64_t slots = window_slots(config);
  if (plan_windows(groups, slots, options.share, options.seed).empty()) {
    return fmt::format("{} windows of {} warps, the fewest, are more than half of {}", kFewestWindows,
                       settling_groups(slots) + measured_groups(slots), groups);
  }
  traces::RayGroup last;  // secondary rays are a second launch, after all primary ones
  reader.read(groups - 1, last);
  return last.kind == traces::RayKind::primary ? "" : "secondary rays are a second launch";
}

}  // namespace

Unmodelled unmodelled(const GpuConfig& config, SimulationMode mode) {
  if (mode == SimulationMode::cycle) return {};
  const nlohmann::ordered_json keys = config_json(config);
  for (const char* key : {"rt.checkpoint.implementation", "rt.box.implementation", "rt.transform.implementation"}) {
    if (keys.at(key) == "tlm") continue;
    return {key, "must be tlm with --mode windows: RTL is compared on whole traces"};
  }
  if (config.dram_model != kBuiltInMemory) {
    return {"dram.model", "must be built_in with --mode windows: the windows' intervals were tried with it"};
  }
  return {};
}

void check_mode(const GpuConfig& config, SimulationMode mode) {
  if (const Unmodelled lack = unmodelled(config, mode)) throw Error(kWindowsMode, lack.key, lack.rule);
}

void check_mode(const SimulationOptions& options, bool heat_maps, SimulationMode mode) {
  if (mode == SimulationMode::cycle) return;
  if (!options.waveform.path.empty() || !options.timeline.path.empty() || heat_maps) {
    throw Error(kWindowsMode, "", "has no waveforms, timelines or heat maps: use --mode cycle");
  }
  if (options.latency) refuse_latency("sim");
  for (const auto& [option, path] :
       {std::pair("--warm", &options.warm_trace), std::pair("--warm-state", &options.warm_state),
        std::pair("--save-state", &options.save_state)}) {
    if (!path->empty()) throw Error(kWindowsMode, option, "needs --mode cycle");
  }
}

void refuse_latency(const std::string& command) { throw Error(command, "--latency", "is for --mode cycle"); }

void check_mode_of_frames(SimulationMode mode) {
  if (mode == SimulationMode::cycle) return;
  throw Error(kWindowsMode, "--views", "needs --mode cycle: windows keep no caches warm from frame to frame");
}

void check_windows(const WindowOptions& options) {
  if (!(options.share >= kLeastOfTrace && options.share <= 1.0)) {
    throw Error(kWindowsMode, "--share", fmt::format("must be at least {} and at most 1", kLeastOfTrace));
  }
  if (!(options.target_error >= 0.0 && options.target_error < 1.0)) {
    throw Error(kWindowsMode, "--target-error", "must be at least 0 and below 100%");
  }
}

void check_windows(const traces::Reader& reader) {
  if (!is_sequence(reader)) return;
  throw Error(reader.path(), "", "a sequence of frames needs cycle mode: windows would start a frame cold");
}

std::string reason_for_whole(const traces::Reader& reader, const GpuConfig& config, const WindowOptions& options) {
  if (options.share > kMostOfTrace) return "as asked for";
  return unsuited(reader, config, options);
}

std::string reason_for_whole(double share) { return share > kMostOfTrace ? "to reach --target-error" : ""; }

bool windows_pay(const traces::Reader& reader, const GpuConfig& config, const WindowOptions& options,
                 std::uint64_t many) {
  return reader.totals().visits() >= many && !is_sequence(reader) && !unmodelled(config, SimulationMode::windows) &&
         unsuited(reader, config, options).empty();
}

}  // namespace grtx::sim
