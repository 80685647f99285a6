// Proves a trace consistent.
#pragma once

#include "grtx/traces/header.h"
#include "grtx/traces/reader.h"

namespace grtx::traces {

/// Proves a trace consistent by replaying the rules on the file alone. Throws Error naming group, lane, round and event
/// of the first violation; returns the totals it counted, which must equal the stored ones.
Totals check(const Reader& reader, bool quiet);

}  // namespace grtx::traces
