// SPDX-License-Identifier: Apache-2.0
// Keys of the any-hit unit. Its counters are below those of the collector, whose place it takes
// (any_hit_collector_config.h).
#pragma once

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
/// The part's row in the table of all parts.
PartInfo part_info(const AnyHitUnitConfig& config);

}  // namespace grtx::modules
