// The results of sweeps: an SQLite file, schema "grtx.sweep/3" (docs/guide/sweep.md). Every change is one transaction.
//
// A database belongs to the plan that filled it last. Whatever else it holds is marked as of an earlier plan, and takes
// part in nothing.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "grtx/lab/sweep/points.h"
#include "grtx/lab/sweep/sqlite.h"
#include "grtx/lab/sweep/task.h"

namespace grtx::sim {

/// What `cost.*` values a point has, from the grtx.cost/1 document of its machine.
struct CostValue {
  std::string name, unit, description;
  double value = 0.0;
};
std::vector<CostValue> cost_values(const nlohmann::ordered_json& cost);

/// Throws Error when the file is no database of a sweep, when something in it has the name of a table of a sweep and is
/// not that table (a view of that name would show other results), or when a point's values are not those of its
/// document. Databases of earlier schemas are read, too.
void check_sweep(const std::string& path);

class SweepDatabase {
 public:
  /// Makes it when there is none. Throws Error when the file is no such database, holds values that are not those of
  /// their documents, or more than a sweep made: a trigger would change what is recorded.
  explicit SweepDatabase(const std::string& path);

  /// Notes the plan's text and machine. What was "running" when a sweep was killed is pending again; with `retry`, so
  /// is what failed, was killed or took too long and is added now.
  void begin(const SweepPlan& plan, const std::string& program, const std::string& build, bool retry);
  /// Adds what is new as pending, as the confirmation of a front and the generations of a search do. With the first of
  /// them since begin() all other points, and the result of a search, are of an earlier plan; not those that are these
  /// in another mode. The configuration of a point, which takes a hundred times as much as the rest of it, is added
  /// when it is run or refused.
  void add(const SweepPoints& points);
  /// Of all points that it holds.
  std::vector<std::string> modes();
  /// How many points are of an earlier plan.
  std::size_t earlier_points();

  /// Of each of these; "" of one that it does not hold.
  std::vector<std::string> statuses_of(const std::vector<SweepPoint>& points);
  std::string status_of_point(const std::string& key);
  std::string status_of_trace(const std::string& key);
  std::string reason_of_point(const std::string& key);
  std::string reason_of_trace(const std::string& key);
  /// A value of a finished point. Throws Error when it has none of that name.
  double value(const std::string& key, const std::string& name);
  /// Names of all values of a finished point.
  std::vector<std::string> value_names(const std::string& key);
  /// "" when there is none.
  std::string meta(const std::string& key);
  void set_meta(const std::string& key, const std::string& value);

  void set_running(const std::vector<Task>& tasks);
  void record(const TaskOutcome& outcome);
  /// Points that will not run, and why.
  struct Refusal {
    const SweepPoint* point = nullptr;
    std::string reason;
  };
  void refuse(const std::vector<Refusal>& refusals);

  /// How many of these points have each status.
  std::map<std::string, std::size_t> summary(const std::vector<SweepPoint>& points);

 private:
  /// The first column of the row of a key; "" when there is none.
  std::string text_of(const char* sql, const std::string& key);
  void record_values(const std::string& key, const TaskOutcome& outcome);

  Sqlite database_;
  std::string program_;
  bool retry_ = false, begun_ = false;
};

struct SweepComparison {
  std::vector<std::string> differences;     ///< lines for people; empty: both hold the same results
  std::array<std::size_t, 2> earlier_plan;  ///< points of an earlier plan, which take no part
};

/// What differs between two sweep databases, apart from what may (wall times, when they were made, where traces lie),
/// at most `limit` lines.
SweepComparison compare_sweeps(const std::string& a, const std::string& b, std::size_t limit = 20);

}  // namespace grtx::sim
