// Statistics of several runs as one table that a person reads and compares with diff: a line a name, a column a run.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

namespace grtx::sim {

/// Tab-separated text, sorted by name of statistic and of run; a value is JSON, what a run does not have is empty.
class StatisticsTable {
 public:
  StatisticsTable() = default;
  /// Reads a file; empty if there is none. Throws Error{path, "line N", rule} for what is no such table.
  explicit StatisticsTable(const std::string& path);

  bool has(const std::string& run) const { return runs_.contains(run); }
  /// {name: value}. Needs has(run).
  nlohmann::ordered_json of(const std::string& run) const;
  /// In the place of what is there of that run. values: {name: value}, each a number, null, a text or a truth value.
  void put(const std::string& run, const nlohmann::ordered_json& values);
  std::string text() const;

 private:
  std::map<std::string, std::map<std::string, std::string>> runs_;  ///< name and value as JSON, by run
};

}  // namespace grtx::sim
