// SPDX-License-Identifier: Apache-2.0
// Node sizes in a node image, which determine what a node fetch reads. Layout vulkan_sim and all type codes follow the
// Intel Xe / Vulkan-Sim layout (mesa-vulkan-sim lvp_acceleration_structure.c, gen_rt_pack.h), which reproduces the
// paper's BVH size table. Layout compact follows the compressed wide BVH of Ylitie, Karras, Laine (HPG 2017).
#pragma once

#include <cstdint>

#include "grtx/traces/modes.h"

namespace grtx::traces {

/// Node types as stored in the node image (Xe encoding). Wide leaves exist in layout quantised, for Gaussians that no
/// code of 32 B can hold; bit 2 is then set on top of the kind.
enum class NodeKind : std::uint8_t {
  internal = 0,
  instance = 1,
  procedural = 3,
  triangle = 4,
  wide_instance = 5,
  wide_procedural = 7
};
constexpr bool is_wide(NodeKind kind) { return kind == NodeKind::wide_instance || kind == NodeKind::wide_procedural; }
/// The kind of a leaf without its width.
constexpr NodeKind without_width(NodeKind kind) {
  return is_wide(kind) ? static_cast<NodeKind>(static_cast<unsigned>(kind) & 3u) : kind;
}
/// The wide form of an instance or procedural leaf.
constexpr NodeKind wide_kind(NodeKind kind) { return static_cast<NodeKind>(static_cast<unsigned>(kind) | 4u); }

// Layout vulkan_sim.
inline constexpr std::uint64_t kNodeUnit = 64;  ///< addresses are multiples of this many bytes
inline constexpr std::uint64_t kHeaderBytes = 64;
inline constexpr std::uint64_t kInternalBytes = 64;  ///< up to six children; 128 for widths 7 and 8
inline constexpr std::uint64_t kTriangleLeafBytes = 64;
inline constexpr std::uint64_t kProceduralLeafBytes = 64;
inline constexpr std::uint64_t kInstanceLeafBytes = 128;
// Layout compact: one unit holds an internal node of eight quantised boxes, four triangles with their six vertices, or
// the part of an instance leaf that traversal needs.
inline constexpr std::uint64_t kCompactUnit = 80;
inline constexpr unsigned kTrianglesOfPatch = 4;  ///< most triangles of a triangle leaf in layout compact

// Layout compressed: every node is one unit of 64 B.
inline constexpr std::uint64_t kCompressedBytes = kNodeUnit;

// Layout quantised: instance and procedural leaves are one unit of 32 B, all other nodes two: internal nodes, triangles
// and wide ellipsoids as in vulkan_sim, wide instances as in compressed.
inline constexpr std::uint64_t kQuantisedUnit = 32;
inline constexpr unsigned kQuantisedWidth = 6;  ///< most children of an internal node

inline constexpr unsigned kMaxWidth = 8;

/// Bytes of an internal node of a BVH with `width` children (2..8): six quantised boxes fill 64 B, eight need two
/// units.
constexpr std::uint64_t internal_bytes(unsigned width) { return width <= 6 ? kInternalBytes : 2 * kInternalBytes; }

/// Bytes of a node of `kind` in a BVH of `width`, in layout vulkan_sim.
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
    case NodeKind::wide_instance:
    case NodeKind::wide_procedural:
      break;  // not in this layout
  }
  return kNodeUnit;
}

/// Node sizes of one acceleration structure. Node addresses are multiples of unit(); events, node definitions and
/// tracer give them in units.
class NodeSizes {
 public:
  /// wide_leaves: whether some leaves are of a wide kind.
  constexpr NodeSizes(NodeLayout layout, unsigned width, bool wide_leaves = false)
      : layout_(layout), width_(width), wide_leaves_(wide_leaves) {}

  constexpr NodeLayout layout() const { return layout_; }
  constexpr unsigned width() const { return width_; }  ///< most children of an internal node
  constexpr bool wide_leaves() const { return wide_leaves_; }
  constexpr std::uint64_t unit() const {  ///< bytes
    return compact() ? kCompactUnit : quantised() ? kQuantisedUnit : kNodeUnit;
  }
  constexpr unsigned units(NodeKind kind) const {
    if (compact()) return kind == NodeKind::instance ? 2 : 1;
    if (compressed()) return 1;
    if (quantised()) return kind == NodeKind::instance || kind == NodeKind::procedural ? 1 : 2;
    return static_cast<unsigned>(node_bytes(kind, width_) / kNodeUnit);
  }
  constexpr std::uint64_t bytes(NodeKind kind) const { return units(kind) * unit(); }
  constexpr std::uint64_t header_bytes() const { return quantised() ? kHeaderBytes : unit(); }
  /// Child boxes that fit an internal node: 6 or 8.
  constexpr unsigned slots() const { return compact() || compressed() || width_ > 6 ? 8 : 6; }
  /// Bytes that a visit reads of a node; of a compact instance leaf only the first unit.
  constexpr std::uint64_t read_bytes(NodeKind kind) const { return compact() ? unit() : bytes(kind); }
  /// Whether read_bytes() of an instance leaf suffice for traversal, and no BLAS header is read.
  constexpr bool short_instances() const { return compact() || compressed() || quantised(); }
  /// Whether the cost of the ray-box unit includes decoding quantised boxes (docs/model/node-image.md).
  constexpr bool decoder_priced() const { return compact() || compressed(); }
  /// Whether the transform of an instance or ellipsoid is stored in codes, so that its unit decodes it.
  constexpr bool coded_transforms() const { return quantised(); }
  /// Triangle tests per visit of a triangle leaf.
  constexpr unsigned triangles() const { return compact() ? kTrianglesOfPatch : 1; }
  friend constexpr bool operator==(const NodeSizes&, const NodeSizes&) = default;

 private:
  constexpr bool compact() const { return layout_ == NodeLayout::compact; }
  constexpr bool compressed() const { return layout_ == NodeLayout::compressed; }
  constexpr bool quantised() const { return layout_ == NodeLayout::quantised; }

  NodeLayout layout_;
  unsigned width_;
  bool wide_leaves_;
};

/// Bytes of a Gaussian's spherical harmonics up to `degree`: three channels per coefficient, fp32 or, in layout
/// quantised, fp16 in whole words.
constexpr std::uint64_t sh_record_bytes(NodeLayout layout, unsigned degree) {
  const std::uint64_t values = 3ULL * (degree + 1) * (degree + 1);
  return layout == NodeLayout::quantised ? (values + 1) / 2 * 4 : values * 4;
}

/// Default BVH width: the number of children that one unit of the layout holds.
constexpr unsigned default_width(NodeLayout layout) {
  return layout == NodeLayout::compact || layout == NodeLayout::compressed ? 8 : 6;
}

/// Checkpoint buffer entry: node address 8 B, TLAS leaf address 8 B, t 4 B (paper, Section IV-B).
inline constexpr std::uint64_t kCheckpointEntryBytes = 20;
/// Eviction buffer entry: primitive id 4 B, t 4 B (paper, Section IV-B).
inline constexpr std::uint64_t kEvictionEntryBytes = 8;

}  // namespace grtx::traces
