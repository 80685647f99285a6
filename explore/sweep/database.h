// SPDX-License-Identifier: Apache-2.0
// The results of sweeps: an SQLite file, schema "grtx.sweep/3" (docs/guide/sweep.md). Every change is one transaction.
//
// A database belongs to the plan that filled it last. All other points are marked as of an earlier plan and ignored.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "grtx/explore/sweep/points.h"
#include "grtx/explore/sweep/sqlite.h"
#include "grtx/explore/sweep/task.h"

namespace grtx::explore {

/// A `cost.*` value of a point; cost_values() extracts them from the grtx.cost/1 document of its machine.
struct CostValue {
  std::string name, unit, description;
  double value = 0.0;
};
std::vector<CostValue> cost_values(const nlohmann::ordered_json& cost);

/// Throws Error if the file is no sweep database, if a table of a sweep is replaced by something else of that name (a
/// view could show other results), or if a point's values differ from its document.
void check_sweep(const std::string& path);

class SweepDatabase {
 public:
  /// Opens or creates the database. Throws Error if the file is no sweep database of the current schema, has values
  /// that differ from their documents, or contains objects not made by a sweep (a trigger could change results).
  explicit SweepDatabase(const std::string& path);

  /// Records the plan's text and machine, and sets "running" entries of a killed sweep to pending. retry: also traces,
  /// and points added in this session, that failed, were killed or timed out.
  void begin(const SweepPlan& plan, const std::string& program, const std::string& build, bool retry);
  /// Adds new points and traces as pending. May be called repeatedly (confirmation of a front, generations of a
  /// search). The first call after begin() assigns all other points to an earlier plan, except the same points in
  /// another mode, and deletes the result of a search. A point's configuration is large and is stored only when the
  /// point is run or refused.
  void add(const SweepPoints& points);
  /// Modes of all points in the database.
  std::vector<std::string> modes();
  /// Number of points of an earlier plan.
  std::size_t earlier_points();

  /// Status of each point; "" if it is not in the database.
  std::vector<std::string> statuses_of(const std::vector<SweepPoint>& points);
  std::string status_of_point(const std::string& key);
  std::string status_of_trace(const std::string& key);
  std::string reason_of_point(const std::string& key);
  std::string reason_of_trace(const std::string& key);
  /// A value of a finished point. Throws Error if it has no value of that name.
  double value(const std::string& key, const std::string& name);
  /// Names of all values of a finished point.
  std::vector<std::string> value_names(const std::string& key);
  /// "" when there is none.
  std::string meta(const std::string& key);
  void set_meta(const std::string& key, const std::string& value);

  void set_running(const std::vector<Task>& tasks);
  void record(const TaskOutcome& outcome);
  /// A point that will not run, and the reason.
  struct Refusal {
    const SweepPoint* point = nullptr;
    std::string reason;
  };
  void refuse(const std::vector<Refusal>& refusals);

  /// Number of these points by status.
  std::map<std::string, std::size_t> summary(const std::vector<SweepPoint>& points);
  /// Why points have no result, each reason with the number of these points.
  std::map<std::string, std::size_t> reasons(const std::vector<SweepPoint>& points);

 private:
  /// First column of the query's row for a key; "" if there is no row.
  std::string text_of(const char* sql, const std::string& key);
  void record_values(const std::string& key, const TaskOutcome& outcome);

  Sqlite database_;
  std::string program_;
  bool retry_ = false, begun_ = false;
};

struct SweepComparison {
  std::vector<std::string> differences;     ///< text for the user; empty: same results
  std::array<std::size_t, 2> earlier_plan;  ///< points of an earlier plan, not compared
};

/// Compares two sweep databases, ignoring wall times, creation times and paths of traces; at most `limit` lines.
SweepComparison compare_sweeps(const std::string& a, const std::string& b, std::size_t limit = 20);

}  // namespace grtx::explore
