// SPDX-License-Identifier: Apache-2.0
// A case of a regression: a trace, the machine that runs it, and the statistics on record.
#pragma once

#include <string>
#include <vector>

#include "grtx/rtl_tlm/estimate/windows/window_simulation.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"

namespace grtx::sim {

/// Tolerance of the statistics whose names match a shell pattern.
struct RegressionTolerance {
  std::string pattern;
  double relative = 0.0;  ///< |found - recorded| / |recorded|
  std::string place;      ///< "line N" of the case
};

/// A setting of a case, and its place in the file.
struct RegressionSetting {
  std::string text;   ///< key=value
  std::string place;  ///< "line N" of the case
};

/// Contents of NAME.case.toml (docs/guide/regress.md). Paths are resolved, and relative to the working directory.
struct RegressionCase {
  std::string name;  ///< below the regression's folder, without the ending
  std::string file;
  std::string record;  ///< the table of its folder, records.tsv
  std::string column;  ///< the case's column in that table: NAME
  std::string trace;
  std::string machine;                            ///< a name, or the path of a file .toml; "" for none
  std::string config;                             ///< "" for none
  std::string design;                             ///< whose own keys are set, below the settings; "" for none
  std::vector<std::string> settings;              ///< key=value
  std::vector<RegressionSetting> setting_places;  ///< of the settings
  SimulationMode mode = SimulationMode::cycle;
  WindowOptions windows;                        ///< windows mode: share and seed
  std::vector<std::string> statistics = {"*"};  ///< shell patterns of statistics to compare; host.* never is
  std::vector<RegressionTolerance> tolerances;  ///< the last matching one holds; none: exact
};

/// The cases in a folder and those below, by name; a file that lists machines is a case NAME@MACHINE for each. Throws
/// Error when there are none, and Error{file, "line N", rule} for whatever is unknown, missing, of the wrong type or
/// out of range.
std::vector<RegressionCase> load_regression(const std::string& folder);

/// Whether a name matches a shell pattern.
bool matches_pattern(const std::string& pattern, const std::string& name);
bool is_compared(const RegressionCase& regression_case, const std::string& statistic);
/// Relative tolerance; 0: exact.
double tolerance_of(const RegressionCase& regression_case, const std::string& statistic);

/// Appends to the case's file a table [[update]] that says when, by what program and why its record is rewritten.
void note_update(const RegressionCase& regression_case, const std::string& program, const std::string& reason);

}  // namespace grtx::sim
