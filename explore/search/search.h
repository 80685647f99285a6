// SPDX-License-Identifier: Apache-2.0
// Searches a design space: screens candidates with NSGA-II, confirms the Pareto front, evaluates it once on the
// evaluation scenes, and reports the effect of each parameter and the path from the reference to the best design.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "grtx/explore/search/search_plan.h"
#include "grtx/explore/sweep/session.h"

namespace grtx::explore {

/// Runs the search and stores its result in the session's database, as meta.search: schema "grtx.search/1"
/// (docs/guide/search.md). The same plan and program give the same result, even if killed and resumed. Throws Error if
/// the reference does not run, or lacks a value that the plan names.
nlohmann::ordered_json run_search(const SearchPlan& plan, const TracerRules& tracer, SweepSession& session, bool quiet);

/// How a result's candidates were screened, in a few words: `cycle, images × 0.5`.
std::string screening_words(const nlohmann::ordered_json& screening);
/// A result as text tables; last the front and the best of it.
std::string search_text(const nlohmann::ordered_json& result);
/// The candidate of the front that is best in each objective, and the constraints that all keep; "" without a front.
std::string best_of_front(const nlohmann::ordered_json& result);
/// A step of a result's path: "l1.bytes: 65536 → 131072".
std::string step_words(const nlohmann::ordered_json& step);
/// Whether a step of a path left each objective as it was.
bool is_idle_step(const nlohmann::ordered_json& path, const nlohmann::ordered_json& step);
/// Bound of a constraint on an objective, over the reference's value; nullopt if there is none, or if it is a number
/// and views have several references.
std::optional<double> limit_over_reference(const nlohmann::ordered_json& result, const std::string& objective);

/// Whether a front was found and no simulation failed.
bool search_succeeded(const nlohmann::ordered_json& result);

}  // namespace grtx::explore
