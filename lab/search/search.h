// Searches a design space: NSGA-II over screened candidates, the front confirmed, then looked at once on the evaluation
// scenes; what each parameter contributes; the way from the reference to the best design.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "grtx/lab/search/search_plan.h"
#include "grtx/lab/sweep/session.h"

namespace grtx::sim {

/// Runs the search and stores its result in the session's database, as meta.search: schema "grtx.search/1"
/// (docs/guide/search.md). The same plan and program give the same result, however often it was killed and resumed.
/// Throws Error for what only running shows: a value that the reference does not have, a reference that does not run.
nlohmann::ordered_json run_search(const SearchPlan& plan, const TracerRules& tracer, SweepSession& session, bool quiet);

/// A result as tables for people.
std::string search_text(const nlohmann::ordered_json& result);

/// A front was found, and no simulation failed.
bool search_succeeded(const nlohmann::ordered_json& result);

}  // namespace grtx::sim
