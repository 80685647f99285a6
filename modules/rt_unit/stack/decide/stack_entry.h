// SPDX-License-Identifier: Apache-2.0
// Layout of a traversal stack entry: the node's address and, if popped nodes are tested against t_max
// (Header::pop_test), its t. The paper gives no layout. Determines storage, spills and stack areas.
#pragma once

#include <algorithm>
#include <bit>

#include "grtx/modules/messages/memory_request.h"
#include "grtx/traces/modes.h"

namespace grtx::modules {

struct StackEntryLayout {
  unsigned bits;         ///< in the warp buffer
  unsigned bytes;        ///< in memory, padded to a power of two
  unsigned in_a_sector;  ///< entries per sector, which are spilled and filled together
};

constexpr StackEntryLayout stack_entry_layout(traces::PopTest pop_test) {
  const unsigned bits = 64 + (pop_test == traces::PopTest::on ? 32 : 0);  // address, fp32
  const unsigned bytes = std::bit_ceil(bits / 8);
  return {bits, bytes, static_cast<unsigned>(kSectorBytes) / bytes};
}

/// An entry of a warp's common stack: address, mask of 32 lanes and, for the pop test, the least t of these lanes.
constexpr StackEntryLayout warp_stack_entry_layout(traces::PopTest pop_test) {
  const unsigned bits = 64 + 32 + (pop_test == traces::PopTest::on ? 32 : 0);
  const unsigned bytes = std::bit_ceil(bits / 8);
  return {bits, bytes, static_cast<unsigned>(kSectorBytes) / bytes};
}

/// Most entries of a depth-first walk's stack: at each of 28 levels a node leaves all its children but one. A tree
/// narrower than 6 has more levels for as many leaves, and stays below the 140 of a 6-wide one.
constexpr unsigned deepest_stack(unsigned bvh_width) { return 28 * (std::max(bvh_width, 6U) - 1); }

}  // namespace grtx::modules
