// SPDX-License-Identifier: Apache-2.0
// Chooses the groups that windows mode simulates: windows of consecutive groups, one in each stratum of the trace.
#pragma once

#include <cstdint>
#include <vector>

namespace grtx::sim {

struct Window {
  std::uint64_t first = 0, end = 0;                  ///< groups that are simulated
  std::uint64_t measured = 0;                        ///< measurement begins at the launch of this group
  std::uint64_t stratum_first = 0, stratum_end = 0;  ///< groups it stands for; strata cover the trace
};

// Length in groups of a window's settling phase (the caches still hold data of the window before) and of its measured
// phase. slots: warp slots of the GPU. Settling is short: stale cache contents cost less accuracy than fewer measured
// groups would (docs/model/windows-mode.md).
constexpr std::uint64_t settling_groups(std::uint64_t slots) { return slots < 8 ? 1 : slots / 8; }
constexpr std::uint64_t measured_groups(std::uint64_t slots) { return 3 * settling_groups(slots); }
inline constexpr std::uint64_t kFewestWindows = 20;

/// Divides the trace into strata of equal size, with one window each: at a random place, in the last stratum at its
/// end, so that the estimated run ends as the whole one does. slots: warp slots of the GPU. Empty if `share` of the
/// groups is less than kFewestWindows windows, or if windows do not fit into their strata. The first window starts with
/// empty caches and therefore settles for `slots` groups, or as many as its stratum has room for.
std::vector<Window> plan_windows(std::uint64_t groups, std::uint64_t slots, double share, std::uint64_t seed);

/// Groups of all windows, ascending.
std::vector<std::uint64_t> groups_of(const std::vector<Window>& windows);

}  // namespace grtx::sim
