// The sums of a trace, group by group. Adding groups in any order gives the same totals.
#pragma once

#include "traces/event.h"
#include "traces/header.h"

namespace grtx::traces {

/// Counts one group. Trusts the group; check() has its own count.
Totals count_totals(const Header& header, const RayGroup& group);

/// Sums, and maxima for the max_* members.
void add_totals(Totals& to, const Totals& from);

}  // namespace grtx::traces
