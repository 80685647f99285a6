// The truth of a finished point is its document. The table `value` repeats its numbers for queries, and must not say
// anything else.
#pragma once

#include "grtx/lab/sweep/sqlite.h"

namespace grtx::sim {

/// Throws Error{database, point, rule} for the first finished point whose values are not those of its document. costs:
/// its document holds them, too; else cost.* cannot be compared.
void check_values(Sqlite& database, bool costs);

}  // namespace grtx::sim
