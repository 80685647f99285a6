// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/page/sweep_results.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <string_view>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/base/json.h"
#include "grtx/explore/sweep/database.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;

void select(explore::Sqlite& database, const std::string& query,
            const std::function<void(const explore::SqliteStatement&)>& each) {
  explore::SqliteStatement row(database, query);
  while (row.step()) each(row);
}

}  // namespace

double ReportedPoint::value(const std::string& name) const {
  const auto found = values.find(name);
  return found == values.end() ? std::numeric_limits<double>::quiet_NaN() : found->second;
}

bool SweepResults::several(std::string ReportedPoint::*field) const {
  return std::any_of(points.begin(), points.end(),
                     [&](const ReportedPoint& p) { return p.*field != points.front().*field; });
}

std::string SweepResults::area() const {
  const auto given = meta.find("area");
  return given == meta.end() ? explore::kChipArea : given->second;
}

bool is_database(const std::string& path) {
  check_regular_file(path);
  constexpr std::string_view kMagic("SQLite format 3\0", 16);
  char begin[16] = {};
  std::ifstream file(path, std::ios::binary);
  file.read(begin, sizeof(begin));
  return file.gcount() == 16 && std::string_view(begin, 16) == kMagic;
}

SweepResults read_sweep_results(const std::string& path) {
  explore::check_sweep(path);
  explore::Sqlite database(path, explore::Sqlite::Open::read_only);
  SweepResults sweep;
  sweep.file = std::filesystem::path(path).filename().string();
  select(database, "SELECT key, value FROM meta ORDER BY key",
         [&](const explore::SqliteStatement& row) { sweep.meta[row.text(0)] = row.text(1); });

  if (const auto search = sweep.meta.find("search"); search != sweep.meta.end()) {
    sweep.search = explore::stored_object(search->second, path, "meta.search");
    if (sweep.search.value("schema", "") != "grtx.search/1") throw Error(path, "meta.search", "must be grtx.search/1");
  }

  std::map<std::int64_t, ReportedPoint> points;
  for (explore::StoredPoint& point : explore::read_points(database))
    static_cast<explore::StoredPoint&>(points[point.id]) = std::move(point);
  std::vector<explore::StoredPoint*> all;
  for (auto& [id, point] : points) all.push_back(&point);
  explore::add_distinguishing_inputs(all);
  select(database, "SELECT point_id, name, value FROM value ORDER BY point_id, name",
         [&](const explore::SqliteStatement& row) {
           const auto point = points.find(row.integer(0));
           if (point == points.end()) throw Error(path, "value of point " + row.text(0), "must belong to a point");
           point->second.values[row.text(1)] = row.null(2) ? std::numeric_limits<double>::quiet_NaN() : row.real(2);
         });
  for (auto& [id, point] : points) {
    if (point.earlier_plan) {
      sweep.earlier.push_back(std::move(point));
      continue;
    }
    for (const auto& [name, value] : point.coordinates.items()) {
      if (std::find(sweep.coordinates.begin(), sweep.coordinates.end(), name) == sweep.coordinates.end()) {
        sweep.coordinates.push_back(name);
      }
    }
    sweep.points.push_back(std::move(point));
  }
  select(database, "SELECT key, scene, options, status, reason, bytes FROM trace ORDER BY key",
         [&](const explore::SqliteStatement& row) {
           sweep.traces.push_back({row.text(0), row.text(1), row.text(2), row.text(3), row.text(4),
                                   static_cast<std::uint64_t>(row.integer(5))});
         });
  std::string content;  // hashed instead of the file, whose bytes depend on the order of writing
  select(database, "SELECT key, status, reason, document FROM point ORDER BY key",
         [&](const explore::SqliteStatement& row) {
           content += row.text(0) + ' ' + row.text(1) + ' ' + row.text(2) + ' ' + hex(xxh3(row.text(3))) + '\n';
         });
  sweep.hash = hex(xxh3(content));
  return sweep;
}

}  // namespace grtx::report
