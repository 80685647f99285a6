// SPDX-License-Identifier: Apache-2.0
// Compares measured values of real machines with simulated ones of a sweep: errors, rank correlation, outliers.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/report/page/sweep_results.h"

namespace grtx::report {

/// A line of a file of measured values (docs/guide/correlate.md).
struct Measured {
  std::size_t line = 0;
  std::string card, source;  ///< "" if the file does not say
  std::string why;           ///< what keeps the value from being simulated; "" if nothing does
  std::string scene;         ///< name in the file; "" if the value is for several scenes
  std::string design;        ///< as in the database: sw, tlas-box, ...
  std::string over;          ///< the value is a speed-up of `design` over this one; "": a quantity of `design`
  std::string quantity = "gpu.time_us";
  std::vector<std::pair<std::string, std::string>> coordinates;  ///< name and value that points must have
  double value = 0.0, low = 0.0, high = 0.0;                     ///< low = high = value if no range is given
  double pixels = 0.0, sms = 0.0, mhz = 0.0;  ///< of the frame and its card, for kFrameMs; 0: not said
};

/// Quantity: milliseconds of the card's whole frame that a crop on some of its SMs stands for
/// (docs/guide/correlate.md).
inline constexpr const char* kFrameMs = "frame.ms";

/// Reads a file of measured values. Throws Error with file and line.
std::vector<Measured> read_measured(const std::string& path);

/// The values of one card. Throws Error if the file has none of it, or if `card` is "" and the file has several.
std::vector<Measured> of_card(const std::vector<Measured>& measured, const std::string& card, const std::string& path);

/// A value that is both measured and simulated: of one scene if both have it, else geometric means over the scenes of
/// each side.
struct Comparison {
  std::string label;
  bool paired = false;
  std::size_t measured_scenes = 1, simulated_scenes = 1;
  double measured = 0.0, measured_low = 0.0, measured_high = 0.0;
  double simulated = 0.0, simulated_low = 0.0, simulated_high = 0.0;
  /// Of the logarithm of simulated over measured, from the spread of the scenes of both sides; 0: one scene on each.
  double standard_error = 0.0;
  double error() const { return simulated / measured - 1.0; }
  double deviations() const;  ///< that logarithm in standard errors; NaN without one
  bool inside() const { return simulated >= measured_low && simulated <= measured_high; }
  /// The same in words, of a figure that is a range.
  const char* inside_words() const { return measured_low == measured_high ? "no range" : inside() ? "yes" : "no"; }
};

struct Correlation {
  std::vector<Comparison> comparisons;
  std::vector<std::string> unmatched;    ///< labels of measured values without simulated ones
  double mean_error = 0.0;               ///< mean of |simulated / measured - 1|
  double factor = 1.0;                   ///< geometric mean of simulated / measured
  double scaled_error = 0.0;             ///< mean error after dividing all simulated values by `factor`
  bool several_units = false;            ///< times and ratios, or several quantities: they have no common order
  double spearman = 0.0, kendall = 0.0;  ///< rank correlation; NaN if fewer than two values, one side all equal, or so
  std::vector<std::string> outliers;     ///< labels; scaled error above 10 % and above twice the median
};

/// Throws Error if a measured value matches several points of a scene, or if none matches any.
Correlation correlate(const std::vector<Measured>& measured, const SweepResults& sweep, const std::string& path);

/// Spearman's rank correlation; ties have the mean of their ranks. NaN if all values of one side are equal.
double spearman_rho(const std::vector<double>& a, const std::vector<double>& b);

std::string correlation_text(const Correlation& correlation);
nlohmann::ordered_json comparison_json(const Comparison& comparison);
nlohmann::ordered_json correlation_json(const Correlation& correlation);
/// HTML page with scatter plot and table. measured: name of the file.
std::string correlation_page(const Correlation& correlation, const std::string& measured, const SweepResults& sweep);

}  // namespace grtx::report
