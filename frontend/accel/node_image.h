// SPDX-License-Identifier: Apache-2.0
// The node image: nodes exactly as the hardware would read them. Layouts: vulkan_sim (Intel Xe, mesa-vulkan-sim
// gen_rt_pack.h), compact (compressed wide BVH, leaves of shared vertices), compressed (eight children in 64 B) and
// quantised (leaves of 32 B), see docs/model/node-image.md. Addresses are bytes from the image's start.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

#include "grtx/base/huge_pages.h"
#include "grtx/frontend/accel/box_encoding.h"
#include "grtx/frontend/gaussian/quantised_gaussian.h"
#include "grtx/frontend/gaussian/slab_intersection.h"
#include "grtx/traces/node_layout.h"

namespace grtx::frontend {

using traces::NodeKind;

/// Byte offsets inside an internal node.
struct InternalLayout {
  unsigned slots;       ///< room for children: 6 or 8
  unsigned child_info;  ///< first child byte; packed: kPackedLeafKind and the masks instead
  unsigned bounds;      ///< lowerX; then upperX, lowerY, upperY, lowerZ, upperZ, one byte per slot each; packed: 7 bits
  bool packed = false;  ///< layout compressed
  friend bool operator==(const InternalLayout&, const InternalLayout&) = default;
};
/// Layout of nodes with 6 or 8 slots and one byte per code.
constexpr InternalLayout internal_layout(unsigned slots) {
  return slots <= 6 ? InternalLayout{6, 22, 28} : InternalLayout{8, 22, 32};
}
constexpr InternalLayout internal_layout(const traces::NodeSizes& sizes) {
  if (sizes.layout() == traces::NodeLayout::compressed) return {8, 16, 22, true};
  return internal_layout(sizes.slots());
}
// Byte offsets in a packed node: kind of its leaf children, mask of used slots, mask of slots with leaves.
inline constexpr unsigned kPackedLeafKind = 16, kPackedUsed = 17, kPackedLeaves = 21;
inline constexpr unsigned kPackedBits = 7;  ///< per code; eight of them take 7 bytes

/// Unpacks eight 7-bit codes from the lowest 56 bits into bytes: each fills the upper bits of its byte.
constexpr std::uint64_t unpacked_codes(std::uint64_t packed) {
  packed = (packed & 0x000000000FFFFFFF) | (packed & 0x00FFFFFFF0000000) << 4;
  packed = (packed & 0x00003FFF00003FFF) | (packed & 0x0FFFC0000FFFC000) << 2;
  packed = (packed & 0x007F007F007F007F) | (packed & 0x3F803F803F803F80) << 1;
  return packed << 1;
}
/// Byte i is 1 if bit i is set, else 0.
constexpr std::uint64_t bits_as_bytes(std::uint8_t bits) {
  const std::uint64_t spread = std::uint64_t{bits} * 0x0101010101010101 & 0x8040201008040201;
  return (spread + 0x7F7F7F7F7F7F7F7F) >> 7 & 0x0101010101010101;
}
/// The child bytes of a node's slots: bits 0-1 size in units, 2-5 kind; 0: unused slot.
inline std::uint64_t child_bytes(const InternalLayout& layout, const std::uint8_t* node) {
  if (layout.packed) {
    return bits_as_bytes(node[kPackedUsed]) + (bits_as_bytes(node[kPackedLeaves]) * node[kPackedLeafKind] << 2);
  }
  // Reads eight at once, which lie inside the node whatever its width.
  std::uint64_t bytes = 0;
  std::memcpy(&bytes, node + layout.child_info, sizeof bytes);
  return layout.slots < 8 ? bytes & ((std::uint64_t{1} << 8 * layout.slots) - 1) : bytes;
}
/// The codes of bound array `number` (0: lowerX, upperX, lowerY, ...), one per slot.
inline void read_codes(const InternalLayout& layout, const std::uint8_t* node, unsigned number, std::uint8_t* codes) {
  if (!layout.packed) {
    std::memcpy(codes, node + layout.bounds + number * layout.slots, layout.slots);
    return;
  }
  std::uint64_t packed = 0;
  std::memcpy(&packed, node + layout.bounds + number * kPackedBits, kPackedBits);
  packed = unpacked_codes(packed);
  std::memcpy(codes, &packed, sizeof packed);
}

/// An internal node decoded for inspection (tests, traces); traversal reads the bytes directly.
struct DecodedInternal {
  std::uint64_t child_base = 0;  ///< byte address of child 0
  unsigned child_count = 0;
  std::array<NodeKind, traces::kMaxWidth> kinds{};
  std::array<Box, traces::kMaxWidth> boxes{};
};

/// Contents of a triangle leaf of layout compact: a patch of up to four triangles of one Gaussian's proxy.
struct PatchRecord {
  std::uint32_t gaussian = 0;
  std::uint32_t code = 0;  ///< FacePatch::code
  std::array<glm::vec3, 6> vertices{};
};

class NodeImage {
 public:
  /// An image of exactly `bytes` bytes (a multiple of the layout's unit), zeroed, aligned to cache lines. box_bits:
  /// 2..8, bits used of a box coordinate; the others are 0, so nodes keep their size. Layout compressed uses at most 7.
  NodeImage(unsigned width, std::uint64_t bytes, unsigned box_bits = 8,
            traces::NodeLayout layout = traces::NodeLayout::vulkan_sim)
      : sizes_(layout, width),
        box_bits_(layout == traces::NodeLayout::compressed && box_bits > kPackedBits ? kPackedBits : box_bits),
        layout_(internal_layout(sizes_)),
        unit_(sizes_.unit()),
        bytes_(bytes),
        lines_((bytes + sizeof(Line) - 1) / sizeof(Line) + 1),
        leaf_index_(bytes / sizes_.unit()) {}

  unsigned width() const { return sizes_.width(); }
  const traces::NodeSizes& sizes() const { return sizes_; }
  const InternalLayout& layout() const { return layout_; }
  const std::uint8_t* data() const { return lines_[0].bytes; }
  const std::uint8_t* node(std::uint64_t address) const { return data() + address; }
  const std::uint8_t* node_at(std::uint32_t units) const { return data() + units * unit_; }
  std::uint64_t size() const { return bytes_; }

  /// Allocates the next `count` bytes (a multiple of the unit); returns their address.
  std::uint64_t allocate(std::uint64_t count);
  std::uint64_t allocated() const { return used_; }

  void write_header(std::uint64_t address, std::uint64_t root, const Box& bounds);
  /// Encodes conservatively: every decoded box contains its ChildRecord's box (checked). In layout compressed all leaf
  /// children must be of one kind.
  void write_internal(std::uint64_t address, std::uint64_t child_base, const ChildRecord* children, unsigned count);
  void write_triangle(std::uint64_t address, std::uint32_t primitive, const glm::vec3& a, const glm::vec3& b,
                      const glm::vec3& c);
  /// to_unit, mean: given for an ellipsoid in the world, for which the ray must be transformed; not for the unit sphere
  /// of a BLAS.
  void write_procedural(std::uint64_t address, std::uint32_t primitive, const glm::vec3* to_unit = nullptr,
                        const glm::vec3& mean = {});
  /// Layout quantised: writes an ellipsoid in the world, or an instance of the shared BLAS.
  void write_quantised(std::uint64_t address, const QuantisedGaussian& gaussian);
  /// Layout quantised: writes the grid behind the bounds of the header.
  void write_mean_grid(std::uint64_t header, const MeanGrid& grid);
  /// Layout compact: writes the triangles of a patch. leaf: index of the leaf among all leaves of the structure.
  void write_patch(std::uint64_t address, const PatchRecord& patch, std::uint32_t leaf);
  /// Layout compact: writes a procedural leaf with its transform. world_to_object: 3x3 rows.
  void write_procedural(std::uint64_t address, std::uint32_t primitive, const Box& box,
                        const glm::vec3 (&world_to_object)[3], const glm::vec3& mean);
  /// world_to_object: 3x3 rows; object_to_world: 3x3 columns and translation, as in the Xe instance leaf.
  void write_instance(std::uint64_t address, std::uint32_t instance, std::uint64_t blas_header, std::uint64_t blas_root,
                      const glm::vec3 (&world_to_object)[3], const glm::vec3 (&object_to_world)[3],
                      const glm::vec3& translation);

  /// Writes the 64 B instance leaf of layout compressed, which is the wide instance leaf of layout quantised.
  void write_compressed_instance(std::uint64_t address, std::uint32_t instance, std::uint64_t blas_root,
                                 const glm::vec3 (&world_to_object)[3], const glm::vec3& translation);

  DecodedInternal decode_internal(std::uint64_t address) const;
  std::uint32_t primitive(std::uint64_t leaf) const { return read_u32(leaf + 8); }  ///< triangle leaf, vulkan_sim
  /// Number of triangles in the triangle leaf at this address.
  unsigned triangle_count(std::uint32_t units) const { return compact() ? patch_code(units) & 7u : 1; }
  /// Vertices of triangle `index` of a triangle leaf, counter-clockwise seen from outside.
  std::array<glm::vec3, 3> triangle(std::uint32_t units, unsigned index) const {
    const std::uint8_t* const leaf = node_at(units);
    if (!compact()) return {vertex(leaf + 16), vertex(leaf + 28), vertex(leaf + 40)};
    if (index == 0) return {vertex(leaf), vertex(leaf + 12), vertex(leaf + 24)};
    const unsigned edge = patch_code(units) >> (8 + 6 * (index - 1));
    return {vertex(leaf + 12 * (edge & 7u)), vertex(leaf + 12 * (edge >> 3 & 7u)), vertex(leaf + 12 * (index + 2))};
  }
  std::uint32_t procedural_primitive(std::uint64_t leaf) const {
    return quantised() ? quantised_gaussian(leaf).id() : read_u32(leaf + (compact() ? 72 : 12));
  }
  std::uint32_t instance_index(std::uint64_t leaf) const {
    return quantised() ? quantised_gaussian(leaf).id() : read_u32(leaf + (compact() ? 64 : layout_.packed ? 56 : 76));
  }
  /// Layout quantised: contents of an instance or procedural leaf.
  QuantisedGaussian quantised_gaussian(std::uint64_t leaf) const {
    QuantisedGaussian gaussian;
    std::memcpy(&gaussian, data() + leaf, sizeof gaussian);
    return gaussian;
  }
  std::uint32_t patch_gaussian(std::uint64_t leaf) const { return read_u32(leaf + 72); }  ///< triangle leaf, compact
  /// Primitive or instance index of the leaf at this address in units. The leaf's bytes hold it, too; here the indices
  /// lie close together, so a tracer that needs nothing else touches a sixteenth of the memory.
  std::uint32_t leaf_index(std::uint32_t units) const { return leaf_index_[units]; }
  const std::uint32_t* leaf_indices() const { return leaf_index_.data(); }
  /// Prefetches all children at `child_base` (units), nodes and leaf indices, even if this ray does not hit them: the
  /// next rays may.
  void prefetch_children(std::uint32_t child_base) const {
    const std::uint8_t* const first = node_at(child_base);
    for (unsigned i = 0; i < 6; ++i) __builtin_prefetch(first + i * sizeof(Line));
    __builtin_prefetch(leaf_indices() + child_base);
    __builtin_prefetch(leaf_indices() + child_base + 16);  // the first child's children are often here
  }
  std::uint32_t read_u32(std::uint64_t address) const {
    std::uint32_t value = 0;
    std::memcpy(&value, data() + address, sizeof value);
    return value;
  }

 private:
  void write_compact_instance(std::uint64_t address, std::uint32_t instance, std::uint64_t blas_header,
                              std::uint64_t blas_root, const glm::vec3 (&world_to_object)[3],
                              const glm::vec3 (&object_to_world)[3], const glm::vec3& translation);
  struct alignas(64) Line {
    std::uint8_t bytes[64];
  };

  std::uint8_t* at(std::uint64_t address) { return reinterpret_cast<std::uint8_t*>(&lines_[0]) + address; }

  bool compact() const { return unit_ == traces::kCompactUnit; }
  bool quantised() const { return unit_ == traces::kQuantisedUnit; }
  std::uint32_t patch_code(std::uint32_t units) const { return read_u32(units * unit_ + 76); }
  static glm::vec3 vertex(const std::uint8_t* bytes) {
    glm::vec3 v;
    std::memcpy(&v, bytes, sizeof v);
    return v;
  }

  traces::NodeSizes sizes_;
  unsigned box_bits_;
  InternalLayout layout_;
  std::uint64_t unit_;
  std::uint64_t bytes_;
  ZeroedPages<Line> lines_;  // one line more than the image: vector loads of a node's last bounds may read past its end
  ZeroedPages<std::uint32_t> leaf_index_;
  std::uint64_t used_ = 0;
};

}  // namespace grtx::frontend
