// SPDX-License-Identifier: Apache-2.0
// Header of a trace: everything about the run that is not an event. Stored as JSON at the start of the file; Totals
// are stored in the footer, because they are known only at the end.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "grtx/traces/modes.h"
#include "grtx/traces/node_layout.h"

namespace grtx::traces {

/// Versions that a reader supports. A writer uses the oldest that can express the header (format_version()).
inline constexpr std::uint32_t kOldestFormatVersion = 4;
inline constexpr std::uint32_t kFormatVersion = 16;
/// Said what the beam around a warp's rays meets, which is gone; the number is not used again.
inline constexpr std::uint32_t kRemovedFormatVersion = 15;

/// An instance leaf of a scene TLAS, which places an object.
struct SceneLeaf {
  std::uint64_t address = 0;  ///< bytes
  std::uint32_t object = 0;   ///< index into Header::object_roots
  friend bool operator==(const SceneLeaf&, const SceneLeaf&) = default;
};

struct Header {
  // Structure, tracing rules and image.
  AccelKind accel = AccelKind::tri20;
  Tracing tracing = Tracing::multi;
  unsigned k = 8;  ///< entries of the k-buffer or list; 1 for tracing = closest
  bool checkpoint = false;
  CheckpointOrder checkpoint_order = CheckpointOrder::fifo;
  unsigned checkpoint_bins = 0;  ///< number of near bins (traces/checkpoint_bins.h); 0: two buffers instead of bins
  ChildOrder child_order = ChildOrder::near_first;
  PopTest pop_test = PopTest::on;
  AnyHit any_hit = AnyHit::immediate;  ///< delayed needs tracing = multi and no checkpointing
  ErtCheck ert_check = ErtCheck::hit;
  /// Nodes of a ray that may be under way at once; more than 1 needs tracing = multi, any_hit = immediate, one level
  /// and no checkpointing.
  unsigned ahead = 1;
  OpacityBound opacity_bound = OpacityBound::off;
  ColourPer colour = ColourPer::hit;
  unsigned width = 0;   ///< image, pixels
  unsigned height = 0;  ///< image, pixels
  unsigned warp_size = 32;
  WarpMapping warp_mapping = WarpMapping::tile8x4;
  std::uint64_t groups = 0;
  /// Number of groups of each frame of a sequence, in order; empty if there is only one frame.
  std::vector<std::uint64_t> frame_groups;
  // Node image. Addresses in events are relative to its first byte.
  NodeLayout layout = NodeLayout::vulkan_sim;
  unsigned bvh_width = 6;
  std::uint64_t wide_leaves = 0;  ///< leaves of a wide kind in the node image; only in layout quantised
  std::uint64_t node_image_bytes = 0;
  std::uint64_t root = 0;  ///< byte address of the (TLAS) root
  bool two_level = false;
  std::uint64_t blas_base = 0;  ///< byte address of the BLAS header; 0 if monolithic
  std::uint64_t blas_root = 0;  ///< byte address of the BLAS root; 0 if monolithic
  std::uint64_t blas_bytes = 0;
  bool blas_root_is_leaf = false;
  // Three levels: a scene TLAS at the image's start, whose leaves lead to the TLASes of objects. Empty otherwise.
  std::vector<std::uint64_t> object_roots;  ///< byte addresses, ascending; a header directly precedes each
  std::vector<SceneLeaf> scene_leaves;      ///< ascending addresses
  // Shader-side records.
  std::uint64_t gaussians = 0;
  unsigned sh_degree = 0;
  std::uint64_t gaussian_record_bytes = 48;  ///< mean, scale, rotation, opacity, padded (3DGRT's record)
  std::uint64_t sh_record_bytes = 12;        ///< traces::sh_record_bytes() of layout and degree
  // Per-ray buffers.
  std::uint64_t checkpoint_capacity = 0;  ///< entries of one checkpoint buffer or bin; 0 if checkpointing is off
  // Identity of the inputs: name -> hash or value (scene, camera, every tracer option).
  std::map<std::string, std::string> inputs;

  /// Number of the frame that group `index` belongs to.
  std::uint32_t frame_of(std::uint64_t index) const {
    std::uint32_t frame = 0;
    while (frame + 1 < frame_groups.size() && index >= frame_groups[frame]) index -= frame_groups[frame++];
    return frame;
  }

  NodeSizes node_sizes() const { return {layout, bvh_width, wide_leaves != 0}; }
  bool three_level() const { return !object_roots.empty(); }
  /// Byte address of the first object's TLAS header, which is the end of the scene TLAS; 0 unless three_level().
  std::uint64_t objects_base() const { return three_level() ? object_roots.front() - node_sizes().header_bytes() : 0; }
};

/// Version of a file with this header. Each version adds to the previous one: 5 pop_test and child order vulkan_sim,
/// 6 scene TLAS, 7 sequence of frames, 8 box leaves, 9 checkpoint bins, 10 tracing list, 11 any_hit and ert_check,
/// 12 ahead, 13 wide leaves, 14 opacity_bound, 16 colour.
inline std::uint32_t format_version(const Header& header) {
  if (header.colour == ColourPer::frame) return 16;
  if (header.opacity_bound == OpacityBound::on) return 14;
  if (header.wide_leaves != 0) return 13;
  if (header.ahead != 1) return 12;
  if (header.any_hit == AnyHit::delayed || header.ert_check == ErtCheck::round) return 11;
  if (header.tracing == Tracing::list) return 10;
  if (header.checkpoint_bins != 0) return 9;
  if (has_box_leaves(header.accel)) return 8;
  if (!header.frame_groups.empty()) return 7;
  if (header.three_level()) return 6;
  return header.pop_test == PopTest::on && header.child_order != ChildOrder::vulkan_sim ? 4 : 5;
}

/// Sums over the whole trace, computed by the writer from the events.
struct Totals {
  std::uint64_t rays = 0;
  std::uint64_t rounds = 0;
  std::uint64_t visits_internal = 0;
  std::uint64_t visits_instance = 0;
  std::uint64_t visits_leaf = 0;
  std::uint64_t culls = 0;
  std::uint64_t any_hit_calls = 0;
  std::uint64_t evictions = 0;
  std::uint64_t checkpoints_written = 0;
  std::uint64_t checkpoints_read = 0;
  std::uint64_t overflows = 0;
  std::uint64_t processed = 0;
  std::uint64_t blended = 0;
  std::uint64_t max_checkpoints_per_round = 0;  ///< most entries one ray had in one buffer
  std::uint64_t max_evictions_per_ray = 0;      ///< most entries one ray had in its eviction buffer
  std::uint64_t visits() const { return visits_internal + visits_instance + visits_leaf; }
  friend bool operator==(const Totals&, const Totals&) = default;
};

}  // namespace grtx::traces
