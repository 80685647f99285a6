// A trace as text, for people.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <optional>

#include "grtx/traces/reader.h"

namespace grtx::traces {

/// Prints the header and totals, then every round and event, one a line, with byte addresses in the node image.
/// `group` and `lane` restrict it to one group and to one ray of each group. Throws Error when they are out of range.
void dump(const Reader& reader, std::ostream& out, std::optional<std::uint64_t> group, std::optional<unsigned> lane);

}  // namespace grtx::traces
