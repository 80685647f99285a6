// SPDX-License-Identifier: Apache-2.0
// results.json of grtx run where a command takes the statistics of one simulation: of a design, on a machine.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace grtx::apps {

/// Whether a document is results.json of grtx run, of this version or an earlier one.
bool is_results(const nlohmann::ordered_json& document);

/// The machines of results.json and the designs that each ran. machine: the only one, by name or file; "" for all.
std::vector<std::pair<std::string, std::vector<std::string>>> runs_of(const nlohmann::ordered_json& results,
                                                                      const std::string& path,
                                                                      const std::string& machine);

/// The statistics of a design in results.json as grtx.stats/1: with configuration, inputs and statistics. machine: its
/// name or file; "" where there is one. Throws Error{path, ...} unless both are there.
nlohmann::ordered_json statistics_of(const nlohmann::ordered_json& results, const std::string& path,
                                     const std::string& design, const std::string& machine);

/// A statistic of {name: {value, ...}}; NaN where it is absent, as windows leave some out.
double statistic_value(const nlohmann::ordered_json& statistics, const std::string& name);
/// "12.3", with a unit behind it; "-" for what is absent.
std::string shown_value(double value, int decimals, const char* unit = "");

}  // namespace grtx::apps
