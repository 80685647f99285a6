// What a trace was made with: the modes that its header names, and that tracer and hardware model both obey.
#pragma once

#include <array>
#include <cstdint>

#include "grtx/base/declare/named_enum.h"

namespace grtx::traces {

/// The acceleration structure: a monolithic BVH over proxies, or a TLAS over one shared BLAS.
enum class AccelKind : std::uint8_t { tri20, tri80, ellipsoid, tlas_tri20, tlas_tri80, tlas_sphere };
constexpr auto enum_names(AccelKind) {
  using enum AccelKind;
  return std::to_array<EnumName<AccelKind>>({{tri20, "tri20"},
                                             {tri80, "tri80"},
                                             {ellipsoid, "ellipsoid"},
                                             {tlas_tri20, "tlas-tri20"},
                                             {tlas_tri80, "tlas-tri80"},
                                             {tlas_sphere, "tlas-sphere"}});
}
constexpr bool is_two_level(AccelKind kind) { return kind >= AccelKind::tlas_tri20; }
/// Its primitive leaves are procedural, not triangles: the proxy is a sphere.
constexpr bool has_procedural_leaves(AccelKind kind) {
  return kind == AccelKind::ellipsoid || kind == AccelKind::tlas_sphere;
}

/// How nodes lie in memory, byte by byte (docs/model/node-image.md). vulkan_sim: a triangle a leaf, in lines of 64 B.
/// compact: as shipped structures do, four triangles a leaf with shared vertices, in lines of 80 B. obb: vulkan_sim
/// with child boxes in a rotated frame of their node. compressed: eight children in 64 B, and leaves of 64 B.
enum class NodeLayout : std::uint8_t { vulkan_sim, compact, obb, compressed };
constexpr auto enum_names(NodeLayout) {
  using enum NodeLayout;
  return std::to_array<EnumName<NodeLayout>>(
      {{vulkan_sim, "vulkan_sim"}, {compact, "compact"}, {obb, "obb"}, {compressed, "compressed"}});
}

/// How a round collects hits. multi: the k nearest, in a sorted k-buffer. single: all, unsorted, in a buffer of k
/// entries, sorted when the round ends. closest: the nearest one, without an any-hit shader. stochastic: the nearest of
/// those for which the any-hit shader's coin says so; each round is a sample of its own.
enum class Tracing : std::uint8_t { multi, single, closest, stochastic };
constexpr auto enum_names(Tracing) {
  using enum Tracing;
  return std::to_array<EnumName<Tracing>>(
      {{multi, "multi"}, {single, "single"}, {closest, "closest"}, {stochastic, "stochastic"}});
}

/// Order in which a replay round reads the source buffer (traces/orders/checkpoint_order.h).
enum class CheckpointOrder : std::uint8_t { fifo, lifo, nearest };
constexpr auto enum_names(CheckpointOrder) {
  using enum CheckpointOrder;
  return std::to_array<EnumName<CheckpointOrder>>({{fifo, "fifo"}, {lifo, "lifo"}, {nearest, "nearest"}});
}

/// Order in which the hit children of a node are visited (traces/orders/child_order.h).
enum class ChildOrder : std::uint8_t { near_first, slot, vulkan_sim };
constexpr auto enum_names(ChildOrder) {
  using enum ChildOrder;
  return std::to_array<EnumName<ChildOrder>>({{near_first, "near_first"}, {slot, "slot"}, {vulkan_sim, "vulkan_sim"}});
}

/// Whether a node on the stack is compared with t_max when it is popped, for which its stack entry holds its t. off:
/// what was pushed is fetched, and only its children fail the test.
enum class PopTest : std::uint8_t { on, off };
constexpr auto enum_names(PopTest) {
  using enum PopTest;
  return std::to_array<EnumName<PopTest>>({{on, "on"}, {off, "off"}});
}

/// How pixels form warps.
enum class WarpMapping : std::uint8_t { tile8x4, linear };
constexpr auto enum_names(WarpMapping) {
  using enum WarpMapping;
  return std::to_array<EnumName<WarpMapping>>({{tile8x4, "tile8x4"}, {linear, "linear"}});
}

}  // namespace grtx::traces
