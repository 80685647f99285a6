// The options of sampled mode, for every command that simulates.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "grtx/rtl_tlm/estimate/sampled/sampled_simulation.h"

namespace grtx::sim {

struct SampledCli {
  double share = SampledOptions{}.share;
  std::string target_error;
  std::uint64_t seed = SampledOptions{}.seed;
  SimulationMode engine = SampledOptions{}.engine;
};

/// --share, --target-error, --seed, --sample-engine.
void add_sampled_options(CLI::App* command, SampledCli& cli);
/// Throws Error for options out of range, and for those given without `--mode sampled`.
SampledOptions sampled_options(const SampledCli& cli, SimulationMode mode);
/// Names on stderr the keys that are set and have no effect in that mode.
void warn_of_ignored_keys(const GpuConfig& config, SimulationMode mode, const SampledOptions& sampled);
/// "x ± half-width" of a confidence interval, as a line for people: what was simulated, how sure the estimate is.
void print_sampled(const SampledResult& result);

}  // namespace grtx::sim
