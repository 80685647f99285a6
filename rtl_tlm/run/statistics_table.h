// SPDX-License-Identifier: Apache-2.0
// Statistics of several runs as a table to read and to compare with diff: a line per statistic, a column per run.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

namespace grtx::sim {

/// Tab-separated text, sorted by names of statistics and runs; values are JSON, and empty where a run has none.
class StatisticsTable {
 public:
  StatisticsTable() = default;
  /// Reads a file; an empty table if there is no file. Throws Error{path, "line N", rule} for a malformed table.
  explicit StatisticsTable(const std::string& path);

  bool has(const std::string& run) const { return runs_.contains(run); }
  /// {name: value}. Needs has(run).
  nlohmann::ordered_json values_of(const std::string& run) const;
  /// Replaces the values of a run. values: {name: value}, each a number, null, a string or a boolean.
  void put(const std::string& run, const nlohmann::ordered_json& values);
  std::string text() const;

 private:
  std::map<std::string, std::map<std::string, std::string>> runs_;  ///< name and value as JSON, by run
};

}  // namespace grtx::sim
