// SPDX-License-Identifier: Apache-2.0
// Counters of one RT unit and of its parts, or their sum over several.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/rt_unit/any_hit_collector/decide/any_hit_collector_config.h"
#include "grtx/modules/rt_unit/checkpoint/decide/checkpoint_config.h"
#include "grtx/modules/rt_unit/intersection/decide/intersection_config.h"
#include "grtx/modules/rt_unit/memory_scheduler/decide/memory_scheduler_config.h"
#include "grtx/modules/rt_unit/prefetcher/decide/prefetcher_config.h"
#include "grtx/modules/rt_unit/scheduler/decide/rt_scheduler_config.h"
#include "grtx/modules/rt_unit/stack/decide/stack_counters.h"
#include "grtx/modules/rt_unit/warp_buffer/decide/warp_buffer_config.h"

namespace grtx::modules {

/// Counters of parts that do not exist stay 0.
struct RtUnitCounters {
  std::uint64_t units = 0;  ///< number of RT units summed
  Cycle cycles = 0;         ///< length of the run; set by describe()
  WarpBufferCounters warp_buffer;
  RtSchedulerCounters scheduler;
  MemorySchedulerCounters memory;
  IntersectionCounters ray_box;
  IntersectionCounters ray_triangle;
  IntersectionCounters ray_sphere;
  IntersectionCounters ray_gaussian;
  IntersectionCounters ray_transform;
  AnyHitCounters any_hit;
  CheckpointCounters checkpoint;
  PrefetchCounters prefetch;
  StackCounters stack;
  OwnCounts own;  ///< extra counters of user-supplied parts

  static const CounterTable<RtUnitCounters>& table();
  void add(const RtUnitCounters& other) { table().add(*this, other); }
  /// cycles: length of the run, for the mean occupancy of a warp buffer.
  void describe(StatisticList& list, const std::string& prefix, Cycle cycles) const;
};

}  // namespace grtx::modules
