// The cycles of a whole run from a thinned one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "grtx/rtl_tlm/estimate/estimate.h"
#include "grtx/rtl_tlm/estimate/windows/group_run.h"
#include "grtx/rtl_tlm/estimate/windows/group_work.h"
#include "grtx/rtl_tlm/estimate/windows/window_plan.h"

namespace grtx::sim {

/// What the cycles of a window are explained by, of one group or of several.
inline constexpr std::size_t kCosts = 3;
struct GroupCosts : std::array<double, kCosts> {
  GroupCosts() : array{} {}
  explicit GroupCosts(const GroupWork& work) : array{work.sectors, work.far, work.steps} {}
};

/// Costs that were met between two cycles, a group's evenly from its launch to its end. costs: by position.
GroupCosts costs_between(const GroupTimes& times, const std::vector<GroupCosts>& costs, double from, double to);

/// Cycles that each cost takes, none negative: least squares over `rows`, whose errors are taken to grow with the root
/// of their cycles.
struct CostRow {
  double cycles = 0.0;
  GroupCosts costs;
};
std::array<double, kCosts> fit_costs(const std::vector<CostRow>& rows);

struct WindowEstimate {
  double cycles = 0.0;
  std::array<double, kCosts> rates{};  ///< cycles a sector, a sector beyond the L2, a dependent step
  double degrees_of_freedom = 1.0;
  /// By window. residual: cycles less those explained, over the window's; influences are of the logarithm of the
  /// cycles, less for what was measured.
  std::vector<GroupEvidence> evidence;
};

/// The generalized regression estimator (Saerndal, Swensson and Wretman, Model Assisted Survey Sampling, chapter 6):
/// rates are fitted to quarters of the windows, cycles of the trace are what its costs take at these, and what the
/// windows took beyond that counts for their strata. times: of the groups of the windows, in their order. costs: of
/// every group of the trace, by index. A window is measured until the next one's first launch; what follows the last
/// launch is the end of the whole run, too.
WindowEstimate estimate_windows(const GroupTimes& times, const std::vector<Window>& windows,
                                const std::vector<GroupCosts>& costs);

}  // namespace grtx::sim
