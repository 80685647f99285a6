// SPDX-License-Identifier: Apache-2.0
// Keys of a warp's common traversal stack (rt.warp_stack), and the choice between it and a stack for each lane.
// Counters of the walk are below those of the scheduler, whose place it takes (rt_scheduler_config.h).
#pragma once

#include <bit>
#include <cstdint>

#include "grtx/base/declare/named_enum.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/lane_loop.h"
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
  unsigned window = 16;      ///< 0: all entries
  unsigned write_ports = 1;  ///< 0: as many as children come
  unsigned tests = 128;      ///< 0: a place for each lane of each node slot
  /// Node slots of an RT unit, and bits of a test's name: its slot and lane.
  std::uint64_t slots(unsigned warps) const { return std::uint64_t{warps} * ahead; }
  unsigned test_bits(unsigned warps) const {
    return static_cast<unsigned>(std::bit_width(slots(warps) * kMaxLanes - 1));
  }
  std::uint64_t places(unsigned warps) const { return tests != 0 ? tests : slots(warps) * kMaxLanes; }
  void parameters(ParameterList& list) {
    list.add("entries", entries, {kFewestEntries, 1024}, "entries",
             "with rt.traversal = warp: stack of a warp in the RT unit; deeper ones spill", kOurs);
    list.add("ahead", ahead, {1, kMostAhead}, "entries",
             "with rt.traversal = warp: entries of a warp's stack that may be under way at once, the topmost ones",
             kOurs);
    list.add(
        "window", window, {0, 1024}, "entries",
        "with rt.traversal = warp: topmost places of a warp's stack, waiting or under way, of which one may start; "
        "0: all",
        kOurs);
    list.add("write_ports", write_ports, {0, 64}, "entries/cycle",
             "with rt.traversal = warp: entries that are written to the stacks of an RT unit in a cycle; 0: any number",
             kOurs);
    list.add("tests", tests, {0, 65536}, "tests",
             "with rt.traversal = warp: places of the queue of each unit; as many tests of nodes, and as many of "
             "leaves, are queued or in pipelines, the others wait in their node slots; 0: places for all",
             kOurs);
  }
};

/// The part's row in the table of all parts; used: whether the machine has the part.
PartInfo part_info(const WarpStackConfig& config, bool used, unsigned ray_banks);

}  // namespace grtx::modules
