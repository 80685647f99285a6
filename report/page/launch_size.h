// SPDX-License-Identifier: Apache-2.0
// Whether a launch fills a machine: with fewer warps than slots more slots change nothing, and a comparison of machines
// or designs measures single warps.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/report/page/run_results.h"

namespace grtx::report {

/// A launch fills a machine from this many warps for each of its slots on, if most of the run then has all slots taken:
/// sim::kMostTail.
inline constexpr unsigned kWarpsPerSlot = 2;

/// The largest launch of a simulation, a frame, and the slots for warps of its machine.
struct LaunchSize {
  double warps = 0.0, slots = 0.0;
  unsigned width = 0, height = 0;  ///< of the image
  double tail = 0.0;               ///< share of the cycles after the last warp has started; 0 if not recorded

  bool known() const { return warps > 0.0 && slots > 0.0; }
  bool fills() const { return warps >= warps_to_fill(); }
  /// Warps of a launch that fills the machine, if its tail takes as long as this one's.
  double warps_to_fill() const;
};

/// Of a simulation: its statistics (name -> {value, ...}), its resolved configuration and its inputs. Not known() where
/// one of them does not say.
LaunchSize launch_size(const nlohmann::ordered_json& statistics, const nlohmann::ordered_json& config,
                       const nlohmann::ordered_json& inputs);

/// Of each design of a run.
std::vector<LaunchSize> launch_sizes(const RunResults& run);

/// "this image has 72 warps for 256 slots: too small to compare machines; take --width 128 --height 128 or more", or
/// "… has 512 warps for 256 slots, and 90 % of the run is tail: …": of the launch that fills its machine least. what:
/// is compared. "" if all fill theirs, or none is known.
std::string too_small_text(const std::vector<LaunchSize>& launches, const std::string& what);

}  // namespace grtx::report
