// SPDX-License-Identifier: Apache-2.0
// A regression: runs a folder of cases and compares their statistics with those on record (docs/guide/regress.md).
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/regress/statistics_difference.h"
#include "grtx/rtl_tlm/run/simulation.h"

namespace grtx::sim {

/// The machine of a case. Throws Error.
using MachineLoader = std::function<GpuConfig(const std::string& machine, const std::string& config,
                                              const std::vector<std::string>& settings)>;

/// The keys that a case's design brings, each "key=value". Throws Error unless its trace is of the design.
using DesignKeys = std::function<std::vector<std::string>(const RegressionCase& regression_case)>;

/// Runs the trace of a case on a machine, in a process of its own. Throws Error for what it does not support (a mode).
using CaseSimulator = std::function<SimulationResult(const RegressionCase& regression_case, const GpuConfig& config)>;

struct RegressionOptions {
  std::string folder;
  std::string cases = "*";          ///< shell pattern of their names
  unsigned jobs = 1;                ///< simulations at a time, each a process of its own
  std::string reason;               ///< not empty: records what differs or is not on record, with this reason
  std::string junit;                ///< file to write; "" for none
  std::optional<std::size_t> each;  ///< differences printed per unit, 0: all; unset: those that changed most
  bool quiet = false;               ///< prints differences only
  bool silent = false;              ///< prints nothing to stdout
  std::string program = "grtx";     ///< name of this program in an [[update]]
  MachineLoader machine;            ///< empty: configuration files and settings only
  DesignKeys design_keys;           ///< empty: a case that names a design is refused
  EnergyPricing price;              ///< empty: no energy statistics
  CaseSimulator simulate;           ///< empty: simulate_case(). For your own units and memory
};

/// Runs the case's trace in the case's mode, with the project's own units. Throws what simulate() throws.
SimulationResult simulate_case(const RegressionCase& regression_case, const GpuConfig& config,
                               const EnergyPricing& price);

/// How one case ended.
struct RegressionOutcome {
  enum class Kind : std::uint8_t {
    equal,
    differs,   ///< statistics differ, a conservation law does not hold, or the model stood still
    recorded,  ///< differed, or had no record; has one now
    refused    ///< bad input
  };
  RegressionCase regression_case;
  Kind kind = Kind::equal;
  StatisticsComparison comparison;
  std::string message;   ///< one line: why it is not equal
  double seconds = 0.0;  ///< wall time of its simulation
};

/// Runs the cases, each in a child process: call it while no other thread of this process runs. Prints the outcomes to
/// stdout unless silent. Throws Error for a wrong case file before anything is run.
std::vector<RegressionOutcome> run_regression(const RegressionOptions& options);

/// "equal", "differs", "recorded" or "refused".
const char* outcome_name(RegressionOutcome::Kind kind);

/// 0: all are equal or recorded; 1: some differ; 2: some were refused.
int exit_code(const std::vector<RegressionOutcome>& outcomes);

/// The outcomes as JUnit XML: a test case each; statistics that differ are a failure, bad input is an error.
std::string junit_xml(const std::string& suite, const std::vector<RegressionOutcome>& outcomes,
                      std::optional<std::size_t> each);

}  // namespace grtx::sim
