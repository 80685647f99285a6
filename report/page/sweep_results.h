// SPDX-License-Identifier: Apache-2.0
// Reads a sweep database (docs/guide/sweep.md) for a report.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/explore/sweep/plan.h"
#include "grtx/explore/sweep/stored_points.h"

namespace grtx::report {

struct ReportedPoint : explore::StoredPoint {
  std::map<std::string, double> values;  ///< statistics and cost.*, by name

  /// NaN if there is no such value.
  double value(const std::string& name) const;
};

struct ReportedTrace {
  std::string key, scene, options, status, reason;
  std::uint64_t bytes = 0;
};

struct SweepResults {
  std::string file;                         ///< without its folder
  std::string hash;                         ///< XXH3 of keys, statuses and documents, ordered by key
  std::map<std::string, std::string> meta;  ///< schema, plan, program, ...
  nlohmann::ordered_json search;            ///< grtx.search/1; null without a search
  std::vector<ReportedPoint> points;        ///< points of the plan, by id; only these are compared
  std::vector<ReportedPoint> earlier;       ///< points of an earlier plan, by id; only listed
  std::vector<ReportedTrace> traces;        ///< sorted by key
  std::vector<std::string> coordinates;     ///< names of all coordinates of `points`, in order of appearance

  /// Whether `points` have more than one value of a field, e.g. scene, design or mode.
  bool several(std::string ReportedPoint::*field) const;
  /// The area that fronts are over: explore::kChipArea or kRtUnitArea.
  std::string area() const;
};

/// Whether the file has the header of an SQLite database.
bool is_database(const std::string& path);
/// Throws Error if the file is no sweep database.
SweepResults read_sweep_results(const std::string& path);

}  // namespace grtx::report
