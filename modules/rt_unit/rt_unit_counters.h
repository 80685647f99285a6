// SPDX-License-Identifier: Apache-2.0
// Counters of one RT unit, or their sum over several.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/modules/rt_unit/any_hit_collector.h"
#include "grtx/modules/rt_unit/any_hit_unit.h"
#include "grtx/modules/rt_unit/checkpoint_unit.h"
#include "grtx/modules/rt_unit/intersection_unit.h"
#include "grtx/modules/rt_unit/memory_scheduler.h"
#include "grtx/modules/rt_unit/rt_scheduler.h"
#include "grtx/modules/rt_unit/sibling_prefetcher.h"
#include "grtx/modules/rt_unit/stack_unit.h"
#include "grtx/modules/rt_unit/warp_buffer.h"

namespace grtx::modules {

/// Counters of parts that do not exist stay 0.
struct RtUnitCounters {
  std::uint64_t units = 0;  ///< number of RT units summed
  Cycle cycles = 0;         ///< length of the run; set by describe()
  WarpBuffer::Counters warp_buffer;
  RtScheduler::Counters scheduler;
  MemoryScheduler::Counters memory;
  IntersectionUnit::Counters ray_box;
  IntersectionUnit::Counters ray_triangle;
  IntersectionUnit::Counters ray_sphere;
  IntersectionUnit::Counters ray_gaussian;
  IntersectionUnit::Counters ray_transform;
  AnyHitCollector::Counters any_hit;
  CheckpointUnit::Counters checkpoint;
  SiblingPrefetcher::Counters prefetch;
  StackUnit::Counters stack;
  OwnCounts own;  ///< extra counters of user-supplied parts

  static const CounterTable<RtUnitCounters>& table();
  void add(const RtUnitCounters& other) { table().add(*this, other); }
  /// cycles: length of the run, for the mean occupancy of a warp buffer.
  void describe(StatisticList& list, const std::string& prefix, Cycle cycles) const;
};

}  // namespace grtx::modules
