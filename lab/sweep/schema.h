// The tables of a sweep's database, by version (docs/guide/sweep.md).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "grtx/base/declare/named_enum.h"
#include "grtx/lab/sweep/sqlite.h"

namespace grtx::sim {

enum class SweepSchema : std::uint8_t {
  loose,         ///< columns took whatever came
  without_plan,  ///< a point did not say its machine, nor whether the plan asks for it
  current
};
constexpr auto enum_names(SweepSchema) {
  return names_in_order<SweepSchema>({"grtx.sweep/1", "grtx.sweep/2", "grtx.sweep/3"});
}

/// The statements that make the tables of a new database.
std::string tables_of(SweepSchema schema);

/// What the database says it is; none when it is no database of a sweep.
std::optional<SweepSchema> schema_of(Sqlite& database);

/// Throws Error when something in it has the name of a table of a sweep and is not that table; strict: or there is
/// anything besides.
void check_tables(Sqlite& database, SweepSchema schema, bool strict);

/// The points of any version as one table expression with the columns of the current one. Of an earlier version,
/// which says neither, the machine is "", and all are of the plan.
std::string points_of(SweepSchema schema);

}  // namespace grtx::sim
