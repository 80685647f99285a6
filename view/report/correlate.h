// Measured figures of real machines against simulated ones of a sweep: errors, rank correlation, who stands out.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/view/report/sweep_results.h"

namespace grtx::sim {

/// A line of a file of measured figures (docs/guide/correlate.md).
struct Measured {
  std::size_t line = 0;
  std::string scene;   ///< as measured; "" when the figure is one of several scenes
  std::string design;  ///< as in the database: sw, tlas-box, ...
  std::string over;    ///< the figure is a speed-up of `design` over this one; "": a quantity of `design` alone
  std::string quantity = "gpu.time_us";
  std::vector<std::pair<std::string, std::string>> coordinates;  ///< of the points: name and value
  double value = 0.0, low = 0.0, high = 0.0;                     ///< low = high = value where no range is given
};

/// Throws Error with file and line.
std::vector<Measured> read_measured(const std::string& path);

/// One figure that both have. Where scenes are the same, of one scene; else geometric means over each side's scenes.
struct Comparison {
  std::string label;
  bool paired = false;
  std::size_t measured_scenes = 1, simulated_scenes = 1;
  double measured = 0.0, measured_low = 0.0, measured_high = 0.0;
  double simulated = 0.0, simulated_low = 0.0, simulated_high = 0.0;
  double error() const { return simulated / measured - 1.0; }
  bool inside() const { return simulated >= measured_low && simulated <= measured_high; }
};

struct Correlation {
  std::vector<Comparison> comparisons;
  std::vector<std::string> unmatched;    ///< measured figures of which the database has nothing, by label
  double mean_error = 0.0;               ///< mean of |simulated / measured - 1|
  double factor = 1.0;                   ///< geometric mean of simulated / measured
  double scaled_error = 0.0;             ///< mean error once all that is simulated is divided by `factor`
  double spearman = 0.0, kendall = 0.0;  ///< of the values; NaN with fewer than two, or when one side ranks nothing
  std::vector<std::string> outliers;  ///< labels; off by more than twice the median of what `factor` leaves, and 10 %
};

/// Throws Error when a figure fits several points of a scene, or when none fits any.
Correlation correlate(const std::vector<Measured>& measured, const SweepResults& sweep, const std::string& path);

/// Spearman's rank correlation; ties have the mean of their ranks. NaN when one side ranks nothing.
double spearman_rho(const std::vector<double>& a, const std::vector<double>& b);

std::string correlation_text(const Correlation& correlation);
nlohmann::ordered_json comparison_json(const Comparison& comparison);
nlohmann::ordered_json correlation_json(const Correlation& correlation);
/// Scatter and table as a page of its own. measured: the name of the file.
std::string correlation_page(const Correlation& correlation, const std::string& measured, const SweepResults& sweep);

}  // namespace grtx::sim
