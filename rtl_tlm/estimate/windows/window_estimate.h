// SPDX-License-Identifier: Apache-2.0
// Estimates the cycles of a whole run from a run of its windows only.
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

/// The costs by which a window's cycles are explained (GroupWork): node sectors, distinct sectors and steps, of one
/// group or of several together.
inline constexpr std::size_t kCosts = 3;
struct GroupCosts : std::array<double, kCosts> {
  GroupCosts() : array{} {}
  explicit GroupCosts(const GroupWork& work) : array{work.sectors, work.distinct, work.steps} {}
};

/// Sum of the groups' costs between two cycles; each group's are spread evenly over its run. costs: by position.
GroupCosts costs_between(const GroupTimes& times, const std::vector<GroupCosts>& costs, double from, double to);

/// An observation of the fit: the cycles that some groups took, and their costs.
struct CostRow {
  double cycles = 0.0;
  GroupCosts costs;
};
/// Cycles per unit of each cost: non-negative least squares over `rows`, whose errors are assumed to grow with the
/// square root of their cycles.
std::array<double, kCosts> fit_costs(const std::vector<CostRow>& rows);

struct WindowEstimate {
  double cycles = 0.0;
  std::array<double, kCosts> rates{};  ///< cycles per node sector, per distinct sector, per step
  double drift = 0.0;                  ///< see CycleEstimate
  /// By window. residual: (measured - fitted cycles) / measured. influence: on the logarithm of the cycles, with the
  /// finite population correction for the measured share of the stratum.
  std::vector<GroupEvidence> evidence;
};

/// The generalized regression estimator (Saerndal, Swensson and Wretman, Model Assisted Survey Sampling, chapter 6):
/// fits the rates to quarters of the windows, applies them to the costs of the whole trace, and adds each window's
/// residual scaled up to its stratum. times: by position in groups_of(windows). costs: by group of the trace. A window
/// is measured until the first launch of the next one; the time before the first window is measured and after the last
/// launch is the whole run's, too.
WindowEstimate estimate_windows(const GroupTimes& times, const std::vector<Window>& windows,
                                const std::vector<GroupCosts>& costs);

}  // namespace grtx::sim
