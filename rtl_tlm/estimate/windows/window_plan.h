// SPDX-License-Identifier: Apache-2.0
// Chooses the groups that windows mode simulates: windows of consecutive groups, one in each stratum of the trace.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace grtx::sim {

struct GpuConfig;

struct Window {
  std::uint64_t first = 0, end = 0;                  ///< groups that are simulated
  std::uint64_t measured = 0;                        ///< measurement begins at the launch of this group
  std::uint64_t stratum_first = 0, stratum_end = 0;  ///< groups it stands for; strata cover the trace
};

// Length in groups of a window's settling phase and of its measured phase: half a wave (as many groups as the GPU has
// warp slots) and one and a half. In less, the groups that are under way are mostly those of the window before. On few
// slots a wave is a handful of groups, which meet L1s that have not settled.
inline constexpr std::uint64_t kLeastSettling = 32;
constexpr std::uint64_t settling_groups(std::uint64_t slots) { return std::max(kLeastSettling, slots / 2); }
constexpr std::uint64_t measured_groups(std::uint64_t slots) { return 3 * settling_groups(slots); }
inline constexpr std::uint64_t kFewestWindows = 20;
/// Of less of a frame the caches meet too little between the windows: 4 of 11 intervals missed at 0.07, all too high.
inline constexpr double kLeastOfTrace = 0.25;
inline constexpr double kMostOfTrace = 0.5;  ///< of which windows are made; beyond, the whole is hardly slower

/// The groups with which a run begins: slots fill, caches are cold. They are simulated and stand for themselves.
constexpr std::uint64_t starting_groups(std::uint64_t slots) { return std::max(settling_groups(slots), slots); }

/// Warp slots for which windows are planned: the machine's, whatever registers leave of them to a design, so that all
/// designs have the same windows.
std::uint64_t window_slots(const GpuConfig& config);

/// Divides what follows the starting groups into strata of equal size, with one window each: at a random place, in the
/// first stratum at its beginning, right behind the starting groups, in the last at its end, so that the estimated run
/// begins and ends as the whole one does. slots: warp slots of the GPU. As many windows as `share` of the groups make,
/// at least kFewestWindows; none if they are more than kMostOfTrace of the groups.
std::vector<Window> plan_windows(std::uint64_t groups, std::uint64_t slots, double share, std::uint64_t seed);

/// Groups of all windows, ascending.
std::vector<std::uint64_t> groups_of(const std::vector<Window>& windows);

}  // namespace grtx::sim
