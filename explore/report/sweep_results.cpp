#include "grtx/explore/report/sweep_results.h"

#include <sqlite3.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <memory>
#include <new>
#include <string_view>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/explore/sweep/database.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;

/// One connection, for reading.
class Database {
 public:
  explicit Database(const std::string& path) : path_(path) {
    sqlite3* handle = nullptr;
    const int code = sqlite3_open_v2(path.c_str(), &handle, SQLITE_OPEN_READONLY, nullptr);
    handle_.reset(handle);
    if (code != SQLITE_OK) fail("");
    sqlite3_busy_timeout(handle, 10000);  // ms; a sweep may be writing
  }

  class Row {
   public:
    explicit Row(sqlite3_stmt* statement) : statement_(statement) {}
    std::string text(int column) const {
      const void* bytes = sqlite3_column_blob(statement_, column);
      const auto count = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
      return bytes == nullptr ? std::string() : std::string(static_cast<const char*>(bytes), count);
    }
    std::int64_t integer(int column) const { return sqlite3_column_int64(statement_, column); }
    double real(int column) const {
      return sqlite3_column_type(statement_, column) == SQLITE_NULL ? std::numeric_limits<double>::quiet_NaN()
                                                                    : sqlite3_column_double(statement_, column);
    }

   private:
    sqlite3_stmt* statement_;
  };

  void select(const std::string& query, const std::function<void(const Row&)>& each) const {
    sqlite3_stmt* raw = nullptr;
    if (sqlite3_prepare_v2(handle_.get(), query.c_str(), -1, &raw, nullptr) != SQLITE_OK) fail(query);
    const std::unique_ptr<sqlite3_stmt, int (*)(sqlite3_stmt*)> statement(raw, sqlite3_finalize);
    int code = SQLITE_ROW;
    while ((code = sqlite3_step(raw)) == SQLITE_ROW) each(Row(raw));
    if (code != SQLITE_DONE) fail(query);
  }

 private:
  [[noreturn]] void fail(const std::string& query) const {
    if (handle_ == nullptr || sqlite3_errcode(handle_.get()) == SQLITE_NOMEM) throw std::bad_alloc();
    throw Error(path_, query, std::string("must be a sweep database: ") + sqlite3_errmsg(handle_.get()));
  }
  std::string path_;
  std::unique_ptr<sqlite3, int (*)(sqlite3*)> handle_{nullptr, sqlite3_close};
};

ordered_json object(const std::string& text, const std::string& path, const std::string& place) {
  const ordered_json json = ordered_json::parse(text.empty() ? "{}" : text, nullptr, false);
  if (!json.is_object()) throw Error(path, place, "must be a JSON object");
  return json;
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

bool is_database(const std::string& path) {
  check_regular_file(path);
  constexpr std::string_view kMagic("SQLite format 3\0", 16);
  char begin[16] = {};
  std::ifstream file(path, std::ios::binary);
  file.read(begin, sizeof(begin));
  return file.gcount() == 16 && std::string_view(begin, 16) == kMagic;
}

SweepResults read_sweep_results(const std::string& path) {
  check_sweep_tables(path);
  const Database database(path);
  SweepResults sweep;
  sweep.file = std::filesystem::path(path).filename().string();
  database.select("SELECT key, value FROM meta ORDER BY key",
                  [&](const Database::Row& row) { sweep.meta[row.text(0)] = row.text(1); });
  if (sweep.meta["schema"] != "grtx.sweep/1") throw Error(path, "meta.schema", "must be grtx.sweep/1");

  if (const auto search = sweep.meta.find("search"); search != sweep.meta.end()) {
    sweep.search = object(search->second, path, "meta.search");
    if (sweep.search.value("schema", "") != "grtx.search/1") throw Error(path, "meta.search", "must be grtx.search/1");
  }

  std::map<std::int64_t, std::size_t> place;
  database.select(
      "SELECT id, key, mode, scene, design, coordinates, config, status, reason FROM point ORDER BY id",
      [&](const Database::Row& row) {
        ReportedPoint point;
        point.id = row.integer(0);
        const std::string where = "point " + std::to_string(point.id);
        point.key = row.text(1);
        point.mode = row.text(2);
        point.scene = row.text(3);
        point.design = row.text(4);
        point.coordinates = object(row.text(5), path, where + ": coordinates");
        point.config = object(row.text(6), path, where + ": config");
        point.status = row.text(7);
        point.reason = row.text(8);
        for (const auto& [name, value] : point.coordinates.items()) {
          if (std::find(sweep.coordinates.begin(), sweep.coordinates.end(), name) == sweep.coordinates.end()) {
            sweep.coordinates.push_back(name);
          }
        }
        place[point.id] = sweep.points.size();
        sweep.points.push_back(std::move(point));
      });
  database.select("SELECT point_id, name, value FROM value ORDER BY point_id, name", [&](const Database::Row& row) {
    const auto point = place.find(row.integer(0));
    if (point == place.end()) throw Error(path, "value of point " + row.text(0), "must belong to a point");
    sweep.points[point->second].values[row.text(1)] = row.real(2);
  });
  database.select("SELECT key, scene, options, status, reason, bytes FROM trace ORDER BY key",
                  [&](const Database::Row& row) {
                    sweep.traces.push_back({row.text(0), row.text(1), row.text(2), row.text(3), row.text(4),
                                            static_cast<std::uint64_t>(row.integer(5))});
                  });
  std::string content;  // of the points; the file's bytes depend on the order in which they were written
  database.select("SELECT key, status, reason, document FROM point ORDER BY key", [&](const Database::Row& row) {
    content += row.text(0) + ' ' + row.text(1) + ' ' + row.text(2) + ' ' + hex(xxh3(row.text(3))) + '\n';
  });
  sweep.hash = hex(xxh3(content));
  return sweep;
}

}  // namespace grtx::sim
