// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/sweep/schema.h"

#include <cctype>
#include <map>
#include <string>

#include "grtx/base/error.h"

namespace grtx::explore {
namespace {

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

std::string schema_of(Sqlite& database) {
  SqliteStatement select(database, "SELECT value FROM meta WHERE key = 'schema'");
  return select.step() ? select.text(0) : "";
}

}  // namespace

void check_schema(Sqlite& database, bool strict) {
  const std::map<std::string, SchemaObject> present = objects_of(database);
  if (!present.contains("meta") || schema_of(database) != kSweepSchema) {
    throw Error(database.path(), "meta.schema", std::string("must be ") + kSweepSchema);
  }
  Sqlite made;
  made.execute(kSweepTables);
  const std::map<std::string, SchemaObject> expected = objects_of(made);
  for (const auto& [name, object] : present) {
    const auto known = expected.find(name);
    if (known == expected.end() && !strict) continue;
    if (known != expected.end() && object.type == known->second.type && object.sql == known->second.sql) continue;
    throw Error(database.path(), object.type + " " + name,
                known != expected.end() ? "is not the table that a sweep makes"
                                        : "was not made by a sweep, and could change its results: drop it");
  }
}

}  // namespace grtx::explore
