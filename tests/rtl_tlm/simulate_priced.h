// SPDX-License-Identifier: Apache-2.0
// simulate() as the program calls it: with the energy of the run.
#pragma once

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "grtx/base/child_process.h"
#include "grtx/explore/cost/energy_statistics.h"
#include "grtx/rtl_tlm/run/simulation.h"
#include "paths.h"

namespace grtx::sim::test {

inline SimulationResult simulate_priced(const std::string& trace, const GpuConfig& config,
                                        SimulationOptions options = {}) {
  options.price = explore::describe_energy;
  return simulate(trace, config, options);
}

/// Statistics of a run on configs/small.toml with settings, which must break no law.
inline nlohmann::ordered_json small_statistics(const std::string& trace, const std::vector<std::string>& settings) {
  ChildProcess child("simulation", [&] {
    const GpuConfig config = load_config(grtx::paths::source_dir() + "/configs/small.toml", settings);
    const SimulationResult result = simulate_priced(trace, config);
    nlohmann::ordered_json answer = {{"stats", result.document.at("stats")}, {"violations", result.violations}};
    return answer.dump();
  });
  const auto answer = nlohmann::ordered_json::parse(child.result());
  EXPECT_EQ(answer.at("violations").size(), 0U) << answer.at("violations").dump();
  return answer.at("stats");
}

}  // namespace grtx::sim::test
