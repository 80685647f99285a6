// What results.json says of a comparison.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "grtx/study/run_designs.h"
#include "grtx/study/trace_designs.h"

namespace grtx::sim {

/// documents: each design's, as simulate_designs() returns them. images: of write_run_images(). plan.mode: the one that
/// was taken. Throws Error for a document of another trace than the one that was traced.
DesignResults design_results(const RunPlan& plan, const DesignComparison& comparison, const TracedDesigns& traced,
                             std::map<std::string, nlohmann::ordered_json> documents,
                             const nlohmann::ordered_json& images);

}  // namespace grtx::sim
