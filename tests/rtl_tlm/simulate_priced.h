// SPDX-License-Identifier: Apache-2.0
// simulate() as the program calls it: with the energy of the run.
#pragma once

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "grtx/base/child_process.h"
#include "grtx/lab/cost/energy_statistics.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"
#include "grtx/rtl_tlm/run/simulation.h"
#include "paths.h"

namespace grtx::sim::test {

/// The machine in that mode; sampled mode samples small traces, too.
inline GpuConfig in_mode(GpuConfig config, SimulationMode mode) {
  if (mode == SimulationMode::sampled) config.sampling = {config.sample.stride, config.sample.offset};
  return config;
}

inline SimulationResult simulate_priced(const std::string& trace, const GpuConfig& config,
                                        SimulationOptions options = {}, SimulationMode mode = SimulationMode::cycle) {
  options.price = lab::describe_energy;
  return simulate(trace, in_mode(config, mode), options);
}

/// Statistics of a run on configs/small.toml with settings, which must break no law.
inline nlohmann::ordered_json small_statistics(const std::string& trace, const std::vector<std::string>& settings,
                                               SimulationMode mode) {
  ChildProcess child("simulation", [&] {
    const GpuConfig config = load_config(grtx::paths::source_dir() + "/configs/small.toml", settings);
    const SimulationResult result = simulate_priced(trace, config, {}, mode);
    nlohmann::ordered_json answer = {{"stats", result.document.at("stats")}, {"violations", result.violations}};
    return answer.dump();
  });
  const auto answer = nlohmann::ordered_json::parse(child.result());
  EXPECT_EQ(answer.at("violations").size(), 0U) << answer.at("violations").dump();
  return answer.at("stats");
}

}  // namespace grtx::sim::test
