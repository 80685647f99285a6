// SPDX-License-Identifier: Apache-2.0
// The document of a finished point is authoritative. The table `value` copies its numbers for queries and must agree
// with it.
#pragma once

#include "grtx/explore/sweep/sqlite.h"

namespace grtx::explore {

/// Throws Error{database, point, rule} for the first finished point whose values differ from its document.
void check_values(Sqlite& database);

}  // namespace grtx::explore
