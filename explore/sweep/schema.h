// SPDX-License-Identifier: Apache-2.0
// The tables of a sweep's database, by version (docs/guide/sweep.md).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "grtx/base/declare/named_enum.h"
#include "grtx/explore/sweep/sqlite.h"

namespace grtx::explore {

enum class SweepSchema : std::uint8_t {
  loose,         ///< columns accepted values of any type
  without_plan,  ///< points had no machine, and no mark of the current plan
  current
};
constexpr auto enum_names(SweepSchema) {
  return names_in_order<SweepSchema>({"grtx.sweep/1", "grtx.sweep/2", "grtx.sweep/3"});
}

/// The statements that make the tables of a new database.
std::string tables_of(SweepSchema schema);

/// Schema named in the database; nullopt if it is no sweep database.
std::optional<SweepSchema> schema_of(Sqlite& database);

/// Throws Error if an object has the name of a sweep's table but another definition. strict: also if there are other
/// objects.
void check_tables(Sqlite& database, SweepSchema schema, bool strict);

/// SQL table expression for the points of any schema, with the current columns. For earlier schemas the machine is ""
/// and all points belong to the plan.
std::string points_of(SweepSchema schema);

}  // namespace grtx::explore
