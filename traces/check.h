// SPDX-License-Identifier: Apache-2.0
// Checks a trace for consistency.
#pragma once

#include "grtx/traces/header.h"
#include "grtx/traces/reader.h"

namespace grtx::traces {

/// Replays the whole trace against the rules of the format, using only the file. Throws Error naming group, lane, round
/// and event of the first violation. Returns the counted totals, which equal the stored ones.
Totals check(const Reader& reader, bool quiet);

}  // namespace grtx::traces
