// SPDX-License-Identifier: Apache-2.0
// Checks a trace for consistency.
#pragma once

#include <string>

#include "grtx/traces/event.h"
#include "grtx/traces/header.h"
#include "grtx/traces/reader.h"

namespace grtx::traces {

/// Replays the whole trace against the rules of the format, using only the file. Throws Error naming group, lane, round
/// and event of the first violation. Returns the counted totals, which equal the stored ones.
Totals check(const Reader& reader, bool quiet);

/// Replays one group by the rules of traces/event.h and the tracer's k-buffer, eviction and checkpoint rules. Throws
/// Error{file, "group G lane L round R event E", rule} at the first violation; safe for arbitrary input. Returns the
/// group's totals. docs/model/trace-format.md lists the rules.
Totals check_group(const std::string& file, const Header& header, const RayGroup& group);

}  // namespace grtx::traces
