// A sweep database (docs/guide/sweep.md) as a report needs it.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/lab/sweep/stored_points.h"

namespace grtx::sim {

struct ReportedPoint : StoredPoint {
  std::map<std::string, double> values;  ///< statistics and cost.*, by name

  /// NaN when there is no such value.
  double value(const std::string& name) const;
};

struct ReportedTrace {
  std::string key, scene, options, status, reason;
  std::uint64_t bytes = 0;
};

struct SweepResults {
  std::string file;                         ///< without its folder
  std::string hash;                         ///< XXH3 of keys, states and documents in the order of the keys
  std::map<std::string, std::string> meta;  ///< schema, plan, program, ...
  nlohmann::ordered_json search;            ///< grtx.search/1, null when no search filled the database
  std::vector<ReportedPoint> points;        ///< of the plan, by id: what is compared with each other
  std::vector<ReportedPoint> earlier;       ///< of an earlier plan, by id: to be shown, and compared with nothing
  std::vector<ReportedTrace> traces;        ///< by key
  std::vector<std::string> coordinates;     ///< names of all coordinates of `points`, in order of appearance

  /// More than one scene, design, or mode among `points`.
  bool several(std::string ReportedPoint::*field) const;
};

/// Whether the file begins like an SQLite database.
bool is_database(const std::string& path);
/// Throws Error when the file is no sweep database.
SweepResults read_sweep_results(const std::string& path);

}  // namespace grtx::sim
