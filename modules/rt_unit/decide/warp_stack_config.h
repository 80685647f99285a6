// SPDX-License-Identifier: Apache-2.0
// Keys of a warp's common traversal stack (rt.warp_stack), and the choice between it and a stack for each lane.
#pragma once

#include <array>
#include <cstdint>

#include "grtx/base/declare/named_enum.h"
#include "grtx/modules/kernel/declare.h"

namespace grtx::modules {

/// lane: each lane has a stack of its own and is at one node at a time. warp: the lanes of a warp share one stack,
/// whose entries are a node and the lanes that visit it.
enum class TraversalWay : std::uint8_t { lane, warp };
constexpr auto enum_names(TraversalWay) { return names_in_order<TraversalWay>({"lane", "warp"}); }

struct WarpStackConfig {
  /// A node's children, and what a sector holds, must fit.
  static constexpr unsigned kFewestEntries = 10;
  static constexpr unsigned kMostAhead = 32;  ///< a test's tag names one of so many node slots
  /// Hits of a warp that are not answered, and leaf tests that may find one, together: four for each lane.
  static constexpr unsigned kHits = 128;

  unsigned entries = 64;
  unsigned ahead = 16;
  void parameters(ParameterList& list) {
    list.add("entries", entries, {kFewestEntries, 1024}, "entries",
             "with rt.traversal = warp: stack of a warp in the RT unit; deeper ones spill", kOurs);
    list.add("ahead", ahead, {1, kMostAhead}, "entries",
             "with rt.traversal = warp: entries of a warp's stack that may be under way at once, the topmost ones",
             kOurs);
  }
};

}  // namespace grtx::modules
