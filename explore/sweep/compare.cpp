// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <set>

#include "grtx/explore/sweep/database.h"
#include "grtx/explore/sweep/schema.h"

namespace grtx::explore {
namespace {

struct Query {
  const char* what;
  const char* sql;  ///< first column: name of the row, rows ordered by it; {0}: table of points to compare
  int columns;
};
// Leaves out wall times, the database's creation time and the paths of traces.
constexpr Query kQueries[] = {
    {"trace",
     "SELECT key, scene, options, bytes, status, reason FROM trace WHERE key IN (SELECT trace_key FROM {0}) ORDER BY "
     "key",
     6},
    {"point",
     "SELECT key, trace_key, machine, mode, scene, design, coordinates, config, status, reason, document FROM {0} "
     "ORDER BY key",
     11},
    {"value",
     "SELECT p.key || ' ' || name, printf('%!.17g', value) FROM value JOIN {0} AS p ON p.id = point_id ORDER BY p.key, "
     "name",
     2},
    {"meta", "SELECT key, value FROM meta WHERE key IN ('schema', 'machine', 'plan', 'program', 'search') ORDER BY key",
     2},
    {"quantity", "SELECT name, unit, description FROM quantity ORDER BY name", 3}};

/// One of the two databases.
struct Side {
  explicit Side(const std::string& path) : database(path, Sqlite::Open::read_only) {
    const std::string all = kSweepPoints;
    points = "(SELECT * FROM " + all + " WHERE NOT earlier_plan)";
    SqliteStatement count(database, "SELECT count(*) FROM " + all + " WHERE earlier_plan");
    count.step();
    earlier_plan = static_cast<std::size_t>(count.integer(0));
  }
  Sqlite database;
  std::string points;
  std::size_t earlier_plan = 0;
};

}  // namespace

SweepComparison compare_sweeps(const std::string& a, const std::string& b, std::size_t limit) {
  for (const std::string& path : {a, b}) check_sweep(path);
  Side first(a), second(b);
  SweepComparison comparison{{}, {first.earlier_plan, second.earlier_plan}};
  std::vector<std::string>& differences = comparison.differences;
  std::set<std::string> alone;  // keys of points of one database, whose values are not listed one by one
  const auto add = [&](const std::string& line) {
    if (differences.size() < limit) differences.push_back(line);
  };
  for (const Query& query : kQueries) {
    // Descriptions also depend on points of earlier plans, so they are compared only without such points.
    if (query.what == std::string("quantity") && first.earlier_plan + second.earlier_plan != 0) continue;
    SqliteStatement x(first.database, fmt::format(fmt::runtime(query.sql), first.points));
    SqliteStatement y(second.database, fmt::format(fmt::runtime(query.sql), second.points));
    const auto only_in = [&](const SqliteStatement& row, const std::string& path) {
      const std::string name = row.text(0);
      const bool is_point = query.what == std::string("point");
      if (is_point) alone.insert(name);
      if (query.what == std::string("value") && alone.contains(name.substr(0, name.find(' ')))) return;
      const std::string called =
          is_point ? fmt::format(" ({}, {}, {}, {})", row.text(2), row.text(4), row.text(5), row.text(6)) : "";
      add(fmt::format("{} {}{} is only in {}", query.what, name, called, path));
    };
    bool more_x = x.step(), more_y = y.step();
    while (more_x || more_y) {
      if (!more_y || (more_x && x.text(0) < y.text(0))) {
        only_in(x, a);
        more_x = x.step();
      } else if (!more_x || y.text(0) < x.text(0)) {
        only_in(y, b);
        more_y = y.step();
      } else {
        for (int column = 1; column < query.columns; ++column) {
          if (x.text(column) == y.text(column)) continue;
          add(fmt::format("{} {}: '{:.60}' and '{:.60}'", query.what, x.text(0), x.text(column), y.text(column)));
          break;
        }
        more_x = x.step();
        more_y = y.step();
      }
    }
  }
  return comparison;
}

}  // namespace grtx::explore
