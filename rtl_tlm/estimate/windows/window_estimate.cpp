// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/estimate/windows/window_estimate.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace grtx::sim {
namespace {

/// Share of group i's time that lies between two cycles.
double share_between(const GroupTimes& times, std::size_t i, double from, double to) {
  const double begin = times.launched[i], length = std::max(1.0, times.ended[i] - begin);
  return std::max(0.0, std::min(to, begin + length) - std::max(from, begin)) / length;
}

double predicted_cycles(const std::array<double, kCosts>& rates, const GroupCosts& costs) {
  return std::inner_product(rates.begin(), rates.end(), costs.begin(), 0.0);
}

}  // namespace

GroupCosts costs_between(const GroupTimes& times, const std::vector<GroupCosts>& costs, double from, double to) {
  GroupCosts sum;
  for (std::size_t i = 0; i < costs.size(); ++i) {
    const double share = share_between(times, i, from, to);
    if (share == 0.0) continue;
    for (std::size_t c = 0; c < kCosts; ++c) sum[c] += share * costs[i][c];
  }
  return sum;
}

std::array<double, kCosts> fit_costs(const std::vector<CostRow>& rows) {
  double mean = 0.0;
  for (const CostRow& row : rows) mean += row.cycles / static_cast<double>(rows.size());
  std::array<std::array<double, kCosts>, kCosts> normal{};
  std::array<double, kCosts> moments{}, rates{};
  for (const CostRow& row : rows) {
    const double weight = 1.0 / std::max({1.0, row.cycles, 0.1 * mean});
    for (std::size_t i = 0; i < kCosts; ++i) {
      moments[i] += weight * row.costs[i] * row.cycles;
      for (std::size_t j = 0; j < kCosts; ++j) normal[i][j] += weight * row.costs[i] * row.costs[j];
    }
  }
  // Coordinate descent with rates kept at 0 or above; it converges because the sum of squares is convex.
  for (int iteration = 0; iteration < 3000; ++iteration) {
    for (std::size_t i = 0; i < kCosts; ++i) {
      if (normal[i][i] <= 0.0) continue;
      double slope = moments[i];
      for (std::size_t j = 0; j < kCosts; ++j) slope -= normal[i][j] * rates[j];
      rates[i] = std::max(0.0, rates[i] + slope / normal[i][i]);
    }
  }
  return rates;
}

WindowEstimate estimate_windows(const GroupTimes& times, const std::vector<Window>& windows,
                                const std::vector<GroupCosts>& costs) {
  constexpr std::uint64_t kQuarters = 4;
  std::vector<GroupCosts> simulated;
  for (const std::uint64_t group : groups_of(windows)) simulated.push_back(costs[group]);
  std::vector<CostRow> quarters;
  std::vector<double> expansion;
  std::size_t position = 0;
  const auto launch = [&times](std::size_t i) { return times.launched[std::min(i, times.launched.size() - 1)]; };
  for (const Window& window : windows) {
    const std::size_t begin = position + window.measured - window.first, end = position + window.end - window.first;
    for (std::uint64_t quarter = 0; quarter < kQuarters; ++quarter) {
      const double from = launch(begin + (end - begin) * quarter / kQuarters);
      const double to = launch(begin + (end - begin) * (quarter + 1) / kQuarters);
      quarters.push_back({to - from, costs_between(times, simulated, from, to)});
    }
    expansion.push_back(static_cast<double>(window.stratum_end - window.stratum_first) /
                        static_cast<double>(end - begin));
    position = end;
  }
  WindowEstimate estimate;
  estimate.rates = fit_costs(quarters);
  for (const GroupCosts& group : costs) estimate.cycles += predicted_cycles(estimate.rates, group);
  std::vector<double> residual_cycles;
  for (std::size_t i = 0; i < windows.size(); ++i) {
    double cycles = 0.0, residual = 0.0;
    for (std::uint64_t quarter = 0; quarter < kQuarters; ++quarter) {
      const CostRow& row = quarters[kQuarters * i + quarter];
      const double more = row.cycles - predicted_cycles(estimate.rates, row.costs);
      cycles += row.cycles;
      residual += more;
      estimate.drift += (2 * quarter < kQuarters ? 1.0 : -1.0) * expansion[i] * more;
    }
    residual_cycles.push_back(residual);
    estimate.evidence.push_back({windows[i].first, residual / std::max(1.0, cycles), 0.0});
    estimate.cycles += expansion[i] * residual;
  }
  const double last = times.launched.back(), end = *std::max_element(times.ended.begin(), times.ended.end());
  const double first = launch(windows.front().measured - windows.front().first);
  for (const auto& [from, to] : {std::pair(0.0, first), std::pair(last, end)}) {
    estimate.cycles += to - from - predicted_cycles(estimate.rates, costs_between(times, simulated, from, to));
  }
  estimate.cycles = std::max(estimate.cycles, end);
  estimate.drift /= estimate.cycles;
  for (std::size_t i = 0; i < windows.size(); ++i) {
    const double unmeasured = std::max(0.0, 1.0 - 1.0 / expansion[i]);
    estimate.evidence[i].influence = expansion[i] * residual_cycles[i] * std::sqrt(unmeasured) / estimate.cycles;
  }
  return estimate;
}

}  // namespace grtx::sim
