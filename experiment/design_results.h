// SPDX-License-Identifier: Apache-2.0
// Builds the content of results.json for a comparison of designs.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/experiment/run_designs.h"
#include "grtx/experiment/trace_designs.h"

namespace grtx::experiment {

/// traced, documents: by machine, as returned by trace_designs() and simulate_designs(). images: list of pictures as in
/// results.json. plan.mode: must be set to the mode that was simulated. With one machine its results are members of
/// results.json; with several they are in the list `machines`, and `between_machines` compares them. Throws Error if a
/// document belongs to another trace than `traced`.
DesignResults design_results(const RunPlan& plan, const DesignComparison& comparison,
                             const std::vector<TracedDesigns>& traced,
                             std::vector<std::map<std::string, nlohmann::ordered_json>> documents,
                             const nlohmann::ordered_json& images);

}  // namespace grtx::experiment
