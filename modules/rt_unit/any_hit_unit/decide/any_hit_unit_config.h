// SPDX-License-Identifier: Apache-2.0
// Keys and counters of the any-hit unit.
#pragma once

#include <cstdint>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/hit_heap.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/rt_unit/part/part_info.h"

namespace grtx::modules {

struct AnyHitUnitConfig : HitHeap {
  unsigned count = 32;
  unsigned bound_latency = 2;
  void parameters(ParameterList& list) {
    HitHeap::parameters(list);
    list.add("count", count, {1, kMaxLanes}, "heaps",
             "heap logic of an RT unit: lane l of each warp uses number l mod count",
             assumed("this project: one for each lane; GauTracer does not say"));
    list.add("bound_latency", bound_latency, {0, kMaxLatency}, "cycles",
             "a trace with opacity_bound: the opacity of a hit that enters is added and compared",
             assumed("this project: one cycle for the table, one for sum and comparison"));
  }
};
/// What the part brings to the table of all parts.
PartInfo part_info(const AnyHitUnitConfig& config);

/// Counters of an any-hit unit; 0 if shaders handle the hits.
struct AnyHitUnitCounters {
  std::uint64_t hits = 0;         ///< timed or not
  std::uint64_t entered = 0;      ///< of these, hits that entered a heap
  std::uint64_t busy_cycles = 0;  ///< heap logic x cycles
  std::uint64_t wait_cycles = 0;  ///< cycles that hits waited for their heap logic
  std::uint64_t answers = 0;      ///< hits answered
  std::uint64_t bounded = 0;      ///< with opacity_bound: hits whose opacity was added
  std::uint64_t hidden = 0;       ///< and entries that left heaps because of it
};

}  // namespace grtx::modules
