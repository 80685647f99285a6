// SPDX-License-Identifier: Apache-2.0
// Configuration of an RT unit and of its parts, with the keys by which people set them.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <string>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/hit_heap.h"
#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/rt_unit/decide/checkpoint_config.h"
#include "grtx/modules/rt_unit/decide/node_traffic.h"
#include "grtx/modules/rt_unit/decide/prefetch_config.h"
#include "grtx/modules/rt_unit/decide/unit_implementation.h"
#include "grtx/modules/rt_unit/decide/warp_selection.h"
#include "grtx/modules/rt_unit/decide/warp_stack_config.h"
#include "grtx/modules/rt_unit/intersection_config.h"
#include "grtx/traces/header.h"

namespace grtx::modules {

/// Stack entries per lane without spilling: a depth-first walk of a 6-wide tree of 28 levels needs at most 28 * 5 =
/// 140.
inline constexpr unsigned kUnspilledStackEntries = 140;

struct WarpBufferConfig {
  unsigned entries = 8;
  unsigned stack_entries = 8;
  bool spill = true;  ///< needs the StackUnit
  unsigned on_chip_entries() const { return spill ? stack_entries : std::max(stack_entries, kUnspilledStackEntries); }
  void parameters(ParameterList& list) {
    list.add("entries", entries, {1, 64}, "warps", "warp buffer of the RT unit", kTable1);
    list.add("stack_entries", stack_entries, {1, 1024}, "entries",
             "traversal stack of a lane in the warp buffer; deeper ones spill", kOurs);
    list.add("spill", spill,
             "stack entries beyond the warp buffer are written to memory and read back; else a stack has 140 entries "
             "there",
             kOurs);
    list.rule(
        "stack_entries", [this] { return !spill || stack_entries >= 2; },
        "must be at least 2 with rt.warp_buffer.spill");
  }
};

struct RtSchedulerConfig {
  std::string policy = "oldest_first";  ///< name of a WarpSelection
  void parameters(ParameterList& list) {
    list.add("policy", policy, warp_selection_names(), "which warp is served in a cycle", kVulkanSim);
  }
};

struct MemorySchedulerConfig {
  unsigned queue = 64;  ///< a warp is scheduled only while kMaxLanes (32) places are free
  bool merge_in_flight = true;
  bool by_shader = false;
  unsigned sectors_per_cycle = 1;
  NodeTrafficConfig traffic;
  void parameters(ParameterList& list) {
    list.add("queue", queue, {kMaxLanes, kMaxEntries}, "fetches", "node fetches waiting to be issued", kOurs);
    list.add("merge_in_flight", merge_in_flight, "a fetch also merges with one of its warp that is still under way",
             from_public("Vulkan-Sim merges within one cycle only"));
    list.add("by_shader", by_shader, "the SIMT core reads the nodes, the RT unit only intersects (as on AMD)",
             from_paper("GRTX, Section IV: the RT unit does"));
    list.add("sectors_per_cycle", sectors_per_cycle, {1, 4}, "sectors/cycle",
             "width of the RT unit's port for nodes at the L1; 4 are the 128 B of recent GPUs", kVulkanSim);
    list.rule(
        "sectors_per_cycle", [this] { return std::has_single_bit(sectors_per_cycle); }, kSectorsRule);
    traffic.parameters(list);
  }
};

struct AnyHitCollectorConfig {
  std::uint64_t timeout = 64;
  void parameters(ParameterList& list) {
    list.add("timeout", timeout, {0, 1e6}, "cycles",
             "an any-hit batch is sent this long after its first lane began to wait", kOurs);
  }
};

struct AnyHitUnitConfig : HitHeap {
  unsigned count = 32;
  void parameters(ParameterList& list) {
    HitHeap::parameters(list);
    list.add("count", count, {1, kMaxLanes}, "heaps",
             "heap logic of an RT unit: lane l of each warp uses number l mod count",
             assumed("this project: one for each lane; GauTracer does not say"));
  }
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
  void parameters(ParameterList& list);
};

}  // namespace grtx::modules
