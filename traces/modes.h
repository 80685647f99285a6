// SPDX-License-Identifier: Apache-2.0
// Modes of a trace, stored in its header and used by both tracer and hardware model.
#pragma once

#include <array>
#include <cstdint>

#include "grtx/base/declare/named_enum.h"

namespace grtx::traces {

/// Acceleration structure: a monolithic BVH over proxies, or a TLAS over one shared BLAS.
enum class AccelKind : std::uint8_t { tri20, tri80, ellipsoid, box, tlas_tri20, tlas_tri80, tlas_sphere, tlas_box };
constexpr auto enum_names(AccelKind) {
  return names_in_order<AccelKind>(
      {"tri20", "tri80", "ellipsoid", "box", "tlas-tri20", "tlas-tri80", "tlas-sphere", "tlas-box"});
}
constexpr bool is_two_level(AccelKind kind) { return kind >= AccelKind::tlas_tri20; }
/// Whether primitive leaves are boxes, whose contents a shader on the SM tests instead of an intersection unit.
constexpr bool has_box_leaves(AccelKind kind) { return kind == AccelKind::box || kind == AccelKind::tlas_box; }
/// Whether primitive leaves are procedural instead of triangles: the proxy is a sphere.
constexpr bool has_procedural_leaves(AccelKind kind) {
  return kind == AccelKind::ellipsoid || kind == AccelKind::tlas_sphere || has_box_leaves(kind);
}

/// Memory layout of nodes (docs/model/node-image.md). vulkan_sim: one triangle per leaf, in units of 64 B. compact:
/// like production structures, four triangles per leaf with shared vertices, in units of 80 B. compressed: eight
/// children in 64 B, leaves of 64 B.
enum class NodeLayout : std::uint8_t { vulkan_sim, compact, compressed, quantised };
constexpr auto enum_names(NodeLayout) {
  return names_in_order<NodeLayout>({"vulkan_sim", "compact", "compressed", "quantised"});
}

/// How a round collects hits. multi: the k nearest, in a sorted k-buffer. single: all, unsorted, in a buffer of k
/// entries, sorted when the round ends. closest: only the nearest one, without an any-hit shader. list: like single,
/// but in a list of k entries that stays unsorted; blending selects the nearest hits from it, a batch at a time.
enum class Tracing : std::uint8_t { multi, single, closest, list };
constexpr auto enum_names(Tracing) { return names_in_order<Tracing>({"multi", "single", "closest", "list"}); }
/// Whether hits are appended unsorted; t_max is unchanged while there is room.
constexpr bool collects_unsorted(Tracing t) { return t == Tracing::single || t == Tracing::list; }

/// Order in which a replay round reads the source buffer (traces/orders/checkpoint_order.h).
enum class CheckpointOrder : std::uint8_t { fifo, lifo, nearest };
constexpr auto enum_names(CheckpointOrder) { return names_in_order<CheckpointOrder>({"fifo", "lifo", "nearest"}); }

/// Order in which the hit children of a node are visited (traces/orders/child_order.h).
enum class ChildOrder : std::uint8_t { near_first, slot, vulkan_sim };
constexpr auto enum_names(ChildOrder) { return names_in_order<ChildOrder>({"near_first", "slot", "vulkan_sim"}); }

/// Whether a popped node is compared with t_max, for which stack entries hold t. off: every pushed node is fetched, and
/// only its children are tested.
enum class PopTest : std::uint8_t { on, off };
constexpr auto enum_names(PopTest) { return names_in_order<PopTest>({"on", "off"}); }

/// When the any-hit shaders run (and the intersection shaders of box leaves). immediate: the ray waits for its shader,
/// which may shrink t_max. delayed: after the traversal of the whole warp, in the order in which the hits were found,
/// so t_max stays what it was when the round began.
enum class AnyHit : std::uint8_t { immediate, delayed };
constexpr auto enum_names(AnyHit) { return names_in_order<AnyHit>({"immediate", "delayed"}); }

/// When blending tests a ray's transmittance for early termination: after each hit, or once per round, after all its
/// hits.
enum class ErtCheck : std::uint8_t { hit, round };
constexpr auto enum_names(ErtCheck) { return names_in_order<ErtCheck>({"hit", "round"}); }

/// Whether t_max also moves to the hit behind which nothing can be seen, as the hits found so far let no light through
/// (traces/rules/opacity_sum.h). on needs tracing = multi, any_hit = immediate and ert_check = hit.
enum class OpacityBound : std::uint8_t { off, on };
constexpr auto enum_names(OpacityBound) { return names_in_order<OpacityBound>({"off", "on"}); }

/// When the colour of a Gaussian is made: for each of its hits, or once in a frame, as fp16, for all rays. frame is for
/// rays from the camera, to which a Gaussian's centre lies in one direction; not for several objects.
enum class ColourPer : std::uint8_t { hit, frame };
constexpr auto enum_names(ColourPer) { return names_in_order<ColourPer>({"hit", "frame"}); }
/// Bytes of such a colour: red, green and blue, and the number of the frame that it was made in.
inline constexpr unsigned kColourBytes = 8;

/// Most nodes of a ray that may be under way at once.
inline constexpr unsigned kMostAhead = 32;

/// How pixels form warps.
enum class WarpMapping : std::uint8_t { tile8x4, linear };
constexpr auto enum_names(WarpMapping) { return names_in_order<WarpMapping>({"tile8x4", "linear"}); }

}  // namespace grtx::traces
