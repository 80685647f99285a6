// SPDX-License-Identifier: Apache-2.0
// Command-line options of simulation modes and estimates, shared by all commands that simulate.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "grtx/rtl_tlm/estimate/windows/window_simulation.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"

namespace grtx::apps {

struct EstimateCli {
  double share = sim::WindowOptions{}.share;
  std::string target_error;
  std::uint64_t seed = sim::WindowOptions{}.seed;
};

/// Adds --mode. The message for a removed mode names its replacement.
CLI::Option* add_mode_option(CLI::App* command, sim::SimulationMode& mode, const std::string& description);
/// Adds --target-error, --share and --seed.
void add_estimate_options(CLI::App* command, EstimateCli& cli);
/// Checks and converts the options. Throws Error for values out of range and for options of another mode.
sim::WindowOptions estimate_options(const EstimateCli& cli, sim::SimulationMode mode);
/// Prints the confidence interval of an estimate and how much was simulated.
void print_interval(const sim::EstimatedResult& result);

}  // namespace grtx::apps
