// SPDX-License-Identifier: Apache-2.0
// Checks the rules of the trace format for a single group.
#pragma once

#include <string>

#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::traces {

/// Replays `group` by the rules of traces/event.h and the tracer's k-buffer, eviction and checkpoint rules. Throws
/// Error{file, "group G lane L round R event E", rule} at the first violation; safe for arbitrary input. Returns the
/// group's totals. docs/model/trace-format.md lists the rules.
Totals check_group(const std::string& file, const Header& header, const RayGroup& group);

}  // namespace grtx::traces
