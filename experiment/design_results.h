// SPDX-License-Identifier: Apache-2.0
// Builds the content of results.json for a comparison of designs.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "grtx/experiment/run_designs.h"
#include "grtx/experiment/trace_designs.h"

namespace grtx::experiment {

/// documents: statistics by design, as returned by simulate_designs(). images: list of pictures as in results.json.
/// plan.mode: must be set to the mode that was simulated. Throws Error if a document belongs to another trace than
/// `traced`.
DesignResults design_results(const RunPlan& plan, const DesignComparison& comparison, const TracedDesigns& traced,
                             std::map<std::string, nlohmann::ordered_json> documents,
                             const nlohmann::ordered_json& images);

}  // namespace grtx::experiment
