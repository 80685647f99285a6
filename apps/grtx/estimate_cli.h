// The options of modes that estimate, for every command that simulates.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "grtx/rtl_tlm/estimate/windows/window_simulation.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"

namespace grtx::sim {

struct EstimateCli {
  double share = WindowOptions{}.share;
  std::string target_error;
  std::uint64_t seed = WindowOptions{}.seed;
};

/// --mode. Says what took the place of a mode that is gone.
CLI::Option* add_mode_option(CLI::App* command, SimulationMode& mode, const std::string& description);
/// --target-error, --share, --seed.
void add_estimate_options(CLI::App* command, EstimateCli& cli);
/// Throws Error for options out of range, and for those of another mode. A target error is one of sampled mode, too.
WindowOptions estimate_options(const EstimateCli& cli, SimulationMode mode);
/// How sure an estimate is, as a line for people: the interval, and what was simulated.
void print_interval(const SampledResult& result);

}  // namespace grtx::sim
