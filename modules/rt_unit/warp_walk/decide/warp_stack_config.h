// SPDX-License-Identifier: Apache-2.0
// Keys of a warp's common traversal stack (rt.warp_stack), and the choice between it and a stack for each lane.
// Counters of the walk are below those of the scheduler, whose place it takes (rt_scheduler_config.h).
#pragma once

#include <cstdint>

#include "grtx/base/declare/named_enum.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/rt_unit/part/part_info.h"

namespace grtx::modules {

/// lane: each lane has a stack of its own and is at one node at a time. warp: the lanes of a warp share one stack,
/// whose entries are a node and the lanes that visit it.
enum class TraversalWay : std::uint8_t { lane, warp };
constexpr auto enum_names(TraversalWay) { return names_in_order<TraversalWay>({"lane", "warp"}); }

struct WarpStackConfig {
  /// A node's children and the entries of a sector must fit.
  static constexpr unsigned kFewestEntries = 10;
  static constexpr unsigned kMostAhead = 32;  ///< a test's tag names one of so many node slots
  /// Most unanswered hits of a warp, together with leaf tests that may find one: four per lane.
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
/// The part's row in the table of all parts; used: whether the machine has the part.
PartInfo part_info(const WarpStackConfig& config, bool used);

}  // namespace grtx::modules
