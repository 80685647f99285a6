// Byte layout of the node image: what one node fetch reads. Sizes and type codes follow the Intel Xe / Vulkan-Sim
// layout (mesa-vulkan-sim lvp_acceleration_structure.c, gen_rt_pack.h), which reproduces the paper's BVH size table.
#pragma once

#include <cstdint>

namespace grtx::traces {

/// Node types as stored in the node image (Xe encoding).
enum class NodeKind : std::uint8_t { internal = 0, instance = 1, procedural = 3, triangle = 4 };

inline constexpr std::uint64_t kNodeUnit = 64;  ///< addresses are multiples of this many bytes
inline constexpr std::uint64_t kHeaderBytes = 64;
inline constexpr std::uint64_t kInternalBytes = 64;  ///< up to six children; 128 for widths 7 and 8
inline constexpr std::uint64_t kTriangleLeafBytes = 64;
inline constexpr std::uint64_t kProceduralLeafBytes = 64;
inline constexpr std::uint64_t kInstanceLeafBytes = 128;
inline constexpr unsigned kMaxWidth = 8;

/// Bytes of an internal node of a BVH with `width` children (2..8): six quantised boxes fill 64 B, eight need two
/// units.
constexpr std::uint64_t internal_bytes(unsigned width) { return width <= 6 ? kInternalBytes : 2 * kInternalBytes; }

/// Bytes of a node of `kind` in a BVH of `width`.
constexpr std::uint64_t node_bytes(NodeKind kind, unsigned width) {
  switch (kind) {
    case NodeKind::internal:
      return internal_bytes(width);
    case NodeKind::instance:
      return kInstanceLeafBytes;
    case NodeKind::procedural:
      return kProceduralLeafBytes;
    case NodeKind::triangle:
      return kTriangleLeafBytes;
  }
  return kNodeUnit;
}

/// Checkpoint buffer entry: node address 8 B, TLAS leaf address 8 B, t 4 B (paper, Section IV-B).
inline constexpr std::uint64_t kCheckpointEntryBytes = 20;
/// Eviction buffer entry: primitive id 4 B, t 4 B (paper, Section IV-B).
inline constexpr std::uint64_t kEvictionEntryBytes = 8;

}  // namespace grtx::traces
