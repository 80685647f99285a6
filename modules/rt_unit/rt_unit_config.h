// SPDX-License-Identifier: Apache-2.0
// Configuration of an RT unit and of its parts, with the keys by which people set them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/hit_heap.h"
#include "grtx/modules/rt_unit/any_hit_collector/decide/any_hit_collector_config.h"
#include "grtx/modules/rt_unit/any_hit_unit/decide/any_hit_unit_config.h"
#include "grtx/modules/rt_unit/checkpoint/decide/checkpoint_config.h"
#include "grtx/modules/rt_unit/decide/unit_implementation.h"
#include "grtx/modules/rt_unit/intersection/decide/intersection_config.h"
#include "grtx/modules/rt_unit/memory_scheduler/decide/memory_scheduler_config.h"
#include "grtx/modules/rt_unit/prefetcher/decide/prefetcher_config.h"
#include "grtx/modules/rt_unit/scheduler/decide/rt_scheduler_config.h"
#include "grtx/modules/rt_unit/warp_buffer/decide/warp_buffer_config.h"
#include "grtx/modules/rt_unit/warp_walk/decide/warp_stack_config.h"
#include "grtx/traces/header.h"
#include "grtx/traces/node_layout.h"

namespace grtx::modules {

/// A port of an RT unit at the L1.
struct RtL1Client {
  std::string name;    ///< rt_node, rt_checkpoint, ...
  unsigned width = 1;  ///< sectors a cycle
  bool first = false;  ///< stands before the SIMT core's port
};

struct RtUnitConfig {
  WarpBufferConfig warp_buffer;
  RtSchedulerConfig scheduler;
  MemorySchedulerConfig memory;
  IntersectionConfig ray_box = kRayBoxUnit;
  IntersectionConfig ray_triangle = kRayTriangleUnit;
  IntersectionConfig ray_sphere = kRaySphereUnit;
  IntersectionConfig ray_gaussian = kRayGaussianUnit;
  IntersectionConfig ray_transform = kRayTransformUnit;
  unsigned leaf_decode_latency = 1;
  UnitImplementation box_implementation = UnitImplementation::tlm;
  UnitImplementation transform_implementation = UnitImplementation::tlm;
  TraversalWay traversal = TraversalWay::lane;
  WarpStackConfig warp_stack;  ///< traversal = warp
  bool gaussian_unit = false;  ///< procedural leaves are tested by ray-Gaussian instead of ray-sphere units
  bool box_op_per_child = false;
  AnyHitCollectorConfig any_hit;
  AnyHitUnitConfig any_hit_unit;
  CheckpointConfig checkpoint;
  bool sibling_prefetch = true;
  PrefetcherConfig prefetcher;
  /// Data path of a ray-box pipeline for a trace with this header.
  DataPath box_path(const traces::Header& header) const {
    const traces::NodeSizes sizes = header.node_sizes();
    return ray_box_path(box_op_per_child ? 1 : header.bvh_width, sizes.decoder_priced());
  }
  /// Data path of a ray-transform pipeline for a trace with this header.
  static DataPath transform_path(const traces::Header& header) {
    return ray_transform_path(header.node_sizes().coded_transforms());
  }
  /// The transform unit for a trace with this header: coded maps are decoded first.
  IntersectionConfig transform_unit(const traces::Header& header) const {
    IntersectionConfig unit = ray_transform;
    if (header.node_sizes().coded_transforms()) unit.latency += leaf_decode_latency;
    return unit;
  }
  /// How tests come to a unit. reads: it reads rays and nodes, else another unit passes them on.
  TestInput test_input(bool reads) const {
    TestInput input;
    if (walks()) {
      input.places = warp_stack.places(warp_buffer.entries);
      input.name_bits = warp_stack.test_bits(warp_buffer.entries);
    }
    if (reads) input.ray_banks = warp_buffer.ray_banks;
    if (reads) input.node_ports = memory.node_ports;
    return input;
  }
  /// Whether an RT unit for a trace with this header has a prefetcher.
  bool has_prefetcher(const traces::Header&) const { return sibling_prefetch && !walks(); }
  /// Whether a warp has one stack. It then runs ahead by itself: there is no sibling prefetcher.
  bool walks() const { return traversal == TraversalWay::warp; }
  /// Whether checkpoint entries name the siblings written with them; 8 B entries have no room for that.
  bool names_siblings_in_entries(const traces::Header& header) const {
    return has_prefetcher(header) && prefetcher.replayed && header.checkpoint && checkpoint.entry_bytes != 8;
  }
  /// Whether ray-Gaussian units test the primitive leaves of a trace with this header.
  bool tests_gaussians(const traces::Header& header) const {
    return gaussian_unit && traces::has_procedural_leaves(header.accel) && !traces::has_box_leaves(header.accel);
  }
  /// The unit that tests the primitive leaves of a trace without boxes.
  const IntersectionConfig& leaf_unit(const traces::Header& header) const {
    if (!traces::has_procedural_leaves(header.accel)) return ray_triangle;
    return gaussian_unit ? ray_gaussian : ray_sphere;
  }
  /// The any-hit unit's heaps as the SIMT core sees them.
  HitHeap heaps(const traces::Header& header) const {
    HitHeap heap = any_hit_unit;
    heap.alpha = tests_gaussians(header);
    return heap;
  }
  /// The L1's clients of an RT unit for a trace with this header, in their order.
  std::vector<RtL1Client> l1_clients(const traces::Header& header) const;
  void parameters(ParameterList& list);
};

}  // namespace grtx::modules
