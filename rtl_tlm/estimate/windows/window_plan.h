// Which groups a thinned run of a large trace holds: windows of consecutive groups, one for each stratum of the trace.
#pragma once

#include <cstdint>
#include <vector>

namespace grtx::sim {

struct Window {
  std::uint64_t first = 0, end = 0;                  ///< groups that are simulated
  std::uint64_t measured = 0;                        ///< group from whose launch on it is measured
  std::uint64_t stratum_first = 0, stratum_end = 0;  ///< groups that they stand for; the strata are the trace
};

// Groups of a window while it settles (the caches still hold what the window before read), and then, while it is
// measured, for a GPU with so many warp slots. What is left of the window before makes less of an error than fewer
// groups that are measured would (docs/results/windows.md).
constexpr std::uint64_t settling_groups(std::uint64_t slots) { return slots < 8 ? 1 : slots / 8; }
constexpr std::uint64_t measured_groups(std::uint64_t slots) { return 3 * settling_groups(slots); }
inline constexpr std::uint64_t kFewestWindows = 20;

/// Strata of equally many groups, a window in each: of the last at its end, so that the thinned run ends as the whole
/// one does, of the others at a place drawn by lot. slots: warp slots of the GPU. Empty if `share` of the groups are
/// fewer than kFewestWindows windows, or if windows would not fit into their strata. The first window settles for as
/// many groups as there are slots, or as its stratum has room for: it starts with empty caches.
std::vector<Window> plan_windows(std::uint64_t groups, std::uint64_t slots, double share, std::uint64_t seed);

/// Groups of all windows, ascending.
std::vector<std::uint64_t> groups_of(const std::vector<Window>& windows);

}  // namespace grtx::sim
