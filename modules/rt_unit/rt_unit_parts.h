// SPDX-License-Identifier: Apache-2.0
// Factories of the parts of an RT unit. A part without a factory is the project's own class; set a factory to replace
// it by your own without editing a file of the project.
#pragma once

#include <functional>
#include <memory>

#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/rt_unit/any_hit_collector/any_hit_if.h"
#include "grtx/modules/rt_unit/checkpoint/checkpoint_if.h"
#include "grtx/modules/rt_unit/intersection/intersection_if.h"
#include "grtx/modules/rt_unit/memory_scheduler/node_fetch_if.h"
#include "grtx/modules/rt_unit/prefetcher/prefetch_if.h"
#include "grtx/modules/rt_unit/scheduler/rt_scheduler_if.h"
#include "grtx/modules/rt_unit/stack/stack_if.h"
#include "grtx/modules/rt_unit/warp_buffer/warp_buffer_if.h"
#include "grtx/traces/header.h"

namespace grtx::modules {

struct RtUnitConfig;

/// Passed to factories. All of it outlives the part.
struct RtUnitContext {
  const RtUnitConfig& config;
  const traces::Header& header;
  const MemoryMap& map;
  const NodeTraffic& traffic;  ///< the bytes that a node visit reads
  unsigned sm;                 ///< number of the SM: selects its per-ray buffers in the map
};

struct RtUnitParts {
  template <typename Part>
  using Factory = std::function<std::unique_ptr<Part>(const char* name, const RtUnitContext& rt)>;

  Factory<WarpBufferModule> warp_buffer;
  Factory<RtSchedulerModule> rt_scheduler;         ///< rt.traversal = lane
  Factory<RtSchedulerModule> warp_walk_scheduler;  ///< rt.traversal = warp
  Factory<NodeFetchModule> memory_scheduler;
  Factory<IntersectionModule> ray_box;
  Factory<IntersectionModule> ray_triangle;
  Factory<IntersectionModule> ray_sphere;
  Factory<IntersectionModule> ray_gaussian;
  Factory<IntersectionModule> ray_transform;
  Factory<AnyHitModule> any_hit_collector;
  // Called only if the configuration or the trace has the part.
  Factory<AnyHitModule> any_hit_unit;
  Factory<AnyHitModule> delayed_hits;
  Factory<CheckpointModule> checkpoint_unit;
  Factory<PrefetchModule> sibling_prefetcher;
  Factory<StackModule> stack_unit;
};

/// Calls f(name, factory) for each factory. A factory added to RtUnitParts does not compile until it is listed here.
template <typename F>
void for_each_factory(RtUnitParts& parts, F&& f) {
  auto& [warp_buffer, rt_scheduler, warp_walk_scheduler, memory_scheduler, ray_box, ray_triangle, ray_sphere,
         ray_gaussian, ray_transform, any_hit_collector, any_hit_unit, delayed_hits, checkpoint_unit,
         sibling_prefetcher, stack_unit] = parts;
  f("warp_buffer", warp_buffer);
  f("rt_scheduler", rt_scheduler);
  f("warp_walk_scheduler", warp_walk_scheduler);
  f("memory_scheduler", memory_scheduler);
  f("ray_box", ray_box);
  f("ray_triangle", ray_triangle);
  f("ray_sphere", ray_sphere);
  f("ray_gaussian", ray_gaussian);
  f("ray_transform", ray_transform);
  f("any_hit_collector", any_hit_collector);
  f("any_hit_unit", any_hit_unit);
  f("delayed_hits", delayed_hits);
  f("checkpoint_unit", checkpoint_unit);
  f("sibling_prefetcher", sibling_prefetcher);
  f("stack_unit", stack_unit);
}

}  // namespace grtx::modules
