// SPDX-License-Identifier: Apache-2.0
// The tables of a sweep's database (docs/guide/sweep.md).
#pragma once

#include "grtx/explore/sweep/sqlite.h"

namespace grtx::explore {

/// The schema of sweeps' databases, as they name it.
inline constexpr const char* kSweepSchema = "grtx.sweep/3";

/// The statements that make the tables of a new database. STRICT: column types are enforced. `present` is a table and
/// not a column of `point`, since SQLite rewrites a whole row, and rows with documents are large.
inline constexpr const char* kSweepTables = R"(
CREATE TABLE IF NOT EXISTS meta(key TEXT PRIMARY KEY, value TEXT) STRICT;
CREATE TABLE IF NOT EXISTS trace(key TEXT PRIMARY KEY, scene TEXT, options TEXT, path TEXT, bytes INTEGER,
                                 status TEXT, reason TEXT, seconds REAL) STRICT;
CREATE TABLE IF NOT EXISTS point(id INTEGER PRIMARY KEY, key TEXT UNIQUE NOT NULL, trace_key TEXT, machine TEXT,
                                 mode TEXT, scene TEXT, design TEXT, coordinates TEXT, config TEXT, status TEXT, reason TEXT,
                                 seconds REAL, document TEXT) STRICT;
CREATE TABLE IF NOT EXISTS value(point_id INTEGER REFERENCES point(id), name TEXT, value REAL,
                                 PRIMARY KEY(point_id, name)) WITHOUT ROWID, STRICT;
CREATE TABLE IF NOT EXISTS quantity(name TEXT PRIMARY KEY, unit TEXT, description TEXT) STRICT;
CREATE TABLE IF NOT EXISTS present(point_id INTEGER PRIMARY KEY REFERENCES point(id)) STRICT;
)";
/// Table expression for the points, with a mark of those that the present plan does not ask for.
inline constexpr const char* kSweepPoints =
    "(SELECT *, id NOT IN (SELECT point_id FROM present) AS earlier_plan FROM point)";

/// Throws Error if this is no sweep's database, or an object has the name of a sweep's table but another definition.
/// strict: also if there are other objects.
void check_schema(Sqlite& database, bool strict);

}  // namespace grtx::explore
