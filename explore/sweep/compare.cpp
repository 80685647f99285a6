#include <fmt/format.h>

#include <functional>

#include "grtx/base/error.h"
#include "grtx/explore/sweep/database.h"

namespace grtx::sim {
namespace {

struct Query {
  const char* what;
  const char* sql;  ///< first column: the row's name; ordered by it
  int columns;
};
// Without wall times, when the database was made, and where its traces lie.
constexpr Query kQueries[] = {
    {"trace", "SELECT key, scene, options, bytes, status, reason FROM trace ORDER BY key", 6},
    {"point",
     "SELECT key, trace_key, mode, scene, design, coordinates, config, status, reason, document FROM point ORDER BY "
     "key",
     10},
    {"value",
     "SELECT point.key || ' ' || name, printf('%!.17g', value) FROM value JOIN point ON point.id = point_id ORDER BY "
     "point.key, name",
     2},
    {"quantity", "SELECT name, unit, description FROM quantity ORDER BY name", 3},
    {"meta", "SELECT key, value FROM meta WHERE key IN ('schema', 'plan', 'program', 'search') ORDER BY key", 2}};

}  // namespace

std::vector<std::string> compare_sweeps(const std::string& a, const std::string& b, std::size_t limit) {
  for (const std::string& path : {a, b}) check_sweep(path);
  Sqlite first(a, Sqlite::Open::read_only), second(b, Sqlite::Open::read_only);
  std::vector<std::string> differences;
  const auto add = [&](const std::string& line) {
    if (differences.size() < limit) differences.push_back(line);
  };
  for (const Query& query : kQueries) {
    SqliteStatement x(first, query.sql), y(second, query.sql);
    bool more_x = x.step(), more_y = y.step();
    while (more_x || more_y) {
      if (!more_y || (more_x && x.text(0) < y.text(0))) {
        add(fmt::format("{} {} is only in {}", query.what, x.text(0), a));
        more_x = x.step();
      } else if (!more_x || y.text(0) < x.text(0)) {
        add(fmt::format("{} {} is only in {}", query.what, y.text(0), b));
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
  return differences;
}

}  // namespace grtx::sim
