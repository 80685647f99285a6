// SPDX-License-Identifier: Apache-2.0
// Prints a trace as text for people, as JSON for programs, or as the reads of other simulators.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <optional>

#include "grtx/base/declare/named_enum.h"
#include "grtx/traces/event.h"
#include "grtx/traces/reader.h"

namespace grtx::traces {

/// Names as in dumps and documentation.
constexpr auto enum_names(EventKind) {
  return names_in_order<EventKind>({"internal", "instance", "leaf", "cull", "take", "forward"});
}
constexpr auto enum_names(LeafOutcome) {
  return names_in_order<LeafOutcome>(
      {"miss", "behind", "beyond", "inserted", "displaced", "rejected", "ignored", "nearest"});
}
constexpr auto enum_names(RayKind) { return names_in_order<RayKind>({"primary", "glass", "mirror"}); }

/// Prints the header and totals, then every round and event, one per line, with byte addresses in the node image.
/// `group` and `lane` restrict it to one group and to one ray of each group. Throws Error if they are out of range.
void dump(const Reader& reader, std::ostream& out, std::optional<std::uint64_t> group, std::optional<unsigned> lane);

/// The same as JSON Lines, with every decoded field: one line for the file, then one per group
/// (docs/model/trace-format.md, "As JSON").
void dump_json(const Reader& reader, std::ostream& out, std::optional<std::uint64_t> group,
               std::optional<unsigned> lane);

/// The reads of each visit in the node image, as a list that any simulator can take: a line per read with warp, lane,
/// round, kind, address and bytes (docs/model/trace-format.md, "As lists of reads").
void dump_nodes(const Reader& reader, std::ostream& out, std::optional<std::uint64_t> group,
                std::optional<unsigned> lane);

}  // namespace grtx::traces
