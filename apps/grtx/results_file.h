// SPDX-License-Identifier: Apache-2.0
// results.json of grtx run where a command takes the statistics of one simulation: of a design, on a machine.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace grtx::apps {

/// Whether a document is results.json of grtx run, of this version or an earlier one.
bool is_results(const nlohmann::ordered_json& document);

/// The statistics of a design in results.json as grtx.stats/1: with configuration, inputs and statistics. machine: its
/// name; "" where there is one. Throws Error{path, ...} unless both are there.
nlohmann::ordered_json statistics_of(const nlohmann::ordered_json& results, const std::string& path,
                                     const std::string& design, const std::string& machine);

}  // namespace grtx::apps
