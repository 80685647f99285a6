// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/sweep/schema.h"

#include <fmt/format.h>

#include <cctype>
#include <map>

#include "grtx/base/error.h"

namespace grtx::explore {
namespace {

/// {0}: STRICT, column types are enforced; {1}: the same for a table without row ids. {2}, {3}: added by the current
/// schema. `present` is a table and not a column of `point`, since SQLite rewrites a whole row, and rows with documents
/// are large.
constexpr const char* kTables = R"(
CREATE TABLE IF NOT EXISTS meta(key TEXT PRIMARY KEY, value TEXT){0};
CREATE TABLE IF NOT EXISTS trace(key TEXT PRIMARY KEY, scene TEXT, options TEXT, path TEXT, bytes INTEGER,
                                 status TEXT, reason TEXT, seconds REAL){0};
CREATE TABLE IF NOT EXISTS point(id INTEGER PRIMARY KEY, key TEXT UNIQUE NOT NULL, trace_key TEXT,{2} mode TEXT,
                                 scene TEXT, design TEXT, coordinates TEXT, config TEXT, status TEXT, reason TEXT,
                                 seconds REAL, document TEXT){0};
CREATE TABLE IF NOT EXISTS value(point_id INTEGER REFERENCES point(id), name TEXT, value REAL,
                                 PRIMARY KEY(point_id, name)) WITHOUT ROWID{1};
CREATE TABLE IF NOT EXISTS quantity(name TEXT PRIMARY KEY, unit TEXT, description TEXT){0};
{3})";
constexpr const char* kPresent =
    "CREATE TABLE IF NOT EXISTS present(point_id INTEGER PRIMARY KEY REFERENCES point(id)) STRICT;\n";

/// A row of sqlite_master.
struct SchemaObject {
  std::string type, sql;
};

/// Schema objects by name, without SQLite's internal ones.
std::map<std::string, SchemaObject> objects_of(Sqlite& database) {
  std::map<std::string, SchemaObject> objects;
  SqliteStatement select(database, "SELECT name, type, sql FROM sqlite_master");
  while (select.step()) {
    std::string sql = select.text(2);
    std::erase_if(sql, [](unsigned char c) { return std::isspace(c) != 0; });
    if (!select.text(0).starts_with("sqlite_")) objects[select.text(0)] = {select.text(1), sql};
  }
  return objects;
}

}  // namespace

std::string tables_of(SweepSchema schema) {
  const bool strict = schema != SweepSchema::loose, plans = schema == SweepSchema::current;
  return fmt::format(kTables, strict ? " STRICT" : "", strict ? ", STRICT" : "", plans ? " machine TEXT," : "",
                     plans ? kPresent : "");
}

std::optional<SweepSchema> schema_of(Sqlite& database) {
  SqliteStatement table(database, "SELECT count(*) FROM sqlite_master WHERE name = 'meta'");
  table.step();
  if (table.integer(0) == 0) return std::nullopt;
  SqliteStatement select(database, "SELECT value FROM meta WHERE key = 'schema'");
  return select.step() ? from_name<SweepSchema>(select.text(0)) : std::nullopt;
}

void check_tables(Sqlite& database, SweepSchema schema, bool strict) {
  Sqlite made;
  made.execute(tables_of(schema));
  const std::map<std::string, SchemaObject> expected = objects_of(made);
  for (const auto& [name, object] : objects_of(database)) {
    const auto known = expected.find(name);
    if (known == expected.end() && !strict) continue;
    if (known != expected.end() && object.type == known->second.type && object.sql == known->second.sql) continue;
    throw Error(database.path(), object.type + " " + name,
                known != expected.end() ? "is not the table that a sweep makes"
                                        : "was not made by a sweep, and could change its results: drop it");
  }
}

std::string points_of(SweepSchema schema) {
  if (schema == SweepSchema::current) {
    return "(SELECT *, id NOT IN (SELECT point_id FROM present) AS earlier_plan FROM point)";
  }
  return "(SELECT *, '' AS machine, 0 AS earlier_plan FROM point)";
}

}  // namespace grtx::explore
