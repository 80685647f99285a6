// A trace as text, for people, and as JSON, for programs.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <optional>

#include "grtx/traces/reader.h"

namespace grtx::traces {

/// Prints the header and totals, then every round and event, one a line, with byte addresses in the node image.
/// `group` and `lane` restrict it to one group and to one ray of each group. Throws Error when they are out of range.
void dump(const Reader& reader, std::ostream& out, std::optional<std::uint64_t> group, std::optional<unsigned> lane);

/// The same as JSON Lines, with every decoded field: a line for the file, then one a group (docs/model/trace-format.md,
/// "As JSON").
void dump_json(const Reader& reader, std::ostream& out, std::optional<std::uint64_t> group,
               std::optional<unsigned> lane);

/// primary, glass, mirror.
const char* name_of(RayKind kind);

}  // namespace grtx::traces
