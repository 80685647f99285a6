// What a trace was made with: the modes that its header names, and that tracer and hardware model both obey.
#pragma once

#include <array>
#include <cstdint>

#include "grtx/base/declare/named_enum.h"

namespace grtx::traces {

/// The acceleration structure: a monolithic BVH over proxies, or a TLAS over one shared BLAS.
enum class AccelKind : std::uint8_t { tri20, tri80, ellipsoid, box, tlas_tri20, tlas_tri80, tlas_sphere, tlas_box };
constexpr auto enum_names(AccelKind) {
  return names_in_order<AccelKind>(
      {"tri20", "tri80", "ellipsoid", "box", "tlas-tri20", "tlas-tri80", "tlas-sphere", "tlas-box"});
}
constexpr bool is_two_level(AccelKind kind) { return kind >= AccelKind::tlas_tri20; }
/// Its primitive leaves are boxes: a shader on the SM tests what lies in them, no unit does.
constexpr bool has_box_leaves(AccelKind kind) { return kind == AccelKind::box || kind == AccelKind::tlas_box; }
/// Its primitive leaves are procedural, not triangles: the proxy is a sphere.
constexpr bool has_procedural_leaves(AccelKind kind) {
  return kind == AccelKind::ellipsoid || kind == AccelKind::tlas_sphere || has_box_leaves(kind);
}

/// How nodes lie in memory, byte by byte (docs/model/node-image.md). vulkan_sim: a triangle a leaf, in lines of 64 B.
/// compact: as shipped structures do, four triangles a leaf with shared vertices, in lines of 80 B. compressed:
/// eight children in 64 B, and leaves of 64 B.
enum class NodeLayout : std::uint8_t { vulkan_sim, compact, compressed };
constexpr auto enum_names(NodeLayout) { return names_in_order<NodeLayout>({"vulkan_sim", "compact", "compressed"}); }

/// How a round collects hits. multi: the k nearest, in a sorted k-buffer. single: all, unsorted, in a buffer of k
/// entries, sorted when the round ends. closest: the nearest one, without an any-hit shader. list: as single,
/// in a list of k entries that stays unsorted; blending picks the nearest from it, a batch at a time.
enum class Tracing : std::uint8_t { multi, single, closest, list };
constexpr auto enum_names(Tracing) { return names_in_order<Tracing>({"multi", "single", "closest", "list"}); }
/// Hits are appended as they come, and no hit that has room moves t_max.
constexpr bool collects_unsorted(Tracing t) { return t == Tracing::single || t == Tracing::list; }

/// Order in which a replay round reads the source buffer (traces/orders/checkpoint_order.h).
enum class CheckpointOrder : std::uint8_t { fifo, lifo, nearest };
constexpr auto enum_names(CheckpointOrder) { return names_in_order<CheckpointOrder>({"fifo", "lifo", "nearest"}); }

/// Order in which the hit children of a node are visited (traces/orders/child_order.h).
enum class ChildOrder : std::uint8_t { near_first, slot, vulkan_sim };
constexpr auto enum_names(ChildOrder) { return names_in_order<ChildOrder>({"near_first", "slot", "vulkan_sim"}); }

/// Whether a node on the stack is compared with t_max when it is popped, for which its stack entry holds its t. off:
/// what was pushed is fetched, and only its children fail the test.
enum class PopTest : std::uint8_t { on, off };
constexpr auto enum_names(PopTest) { return names_in_order<PopTest>({"on", "off"}); }

/// How pixels form warps.
enum class WarpMapping : std::uint8_t { tile8x4, linear };
constexpr auto enum_names(WarpMapping) { return names_in_order<WarpMapping>({"tile8x4", "linear"}); }

}  // namespace grtx::traces
