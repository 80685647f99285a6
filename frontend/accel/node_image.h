// The node image: nodes exactly as the hardware would read them. Layout: Intel Xe / Vulkan-Sim (mesa-vulkan-sim
// gen_rt_pack.h), see docs/model/node-image.md. Addresses are bytes from the image's start.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

#include "grtx/base/huge_pages.h"
#include "grtx/frontend/accel/box_encoding.h"
#include "grtx/frontend/gaussian/slab_intersection.h"
#include "grtx/traces/node_layout.h"

namespace grtx::frontend {

using traces::NodeKind;

/// Byte offsets inside an internal node of up to `width` children.
struct InternalLayout {
  unsigned slots;       ///< bytes reserved a bound array: 6, or 8 for widths 7 and 8
  unsigned child_info;  ///< first child byte
  unsigned bounds;      ///< lowerX; then upperX, lowerY, upperY, lowerZ, upperZ, `slots` bytes each
};
constexpr InternalLayout internal_layout(unsigned width) {
  return width <= 6 ? InternalLayout{6, 22, 28} : InternalLayout{8, 22, 32};
}

/// An internal node decoded for inspection (tests, traces); traversal reads the bytes directly.
struct DecodedInternal {
  std::uint64_t child_base = 0;  ///< byte address of child 0
  unsigned child_count = 0;
  std::array<NodeKind, traces::kMaxWidth> kinds{};
  std::array<Box, traces::kMaxWidth> boxes{};
};

class NodeImage {
 public:
  /// An image of exactly `bytes` bytes (a multiple of 64), zeroed, aligned to cache lines. box_bits: 2..8, bits of a
  /// box coordinate that are used; the rest are zero, so nodes are as large as with 8.
  NodeImage(unsigned width, std::uint64_t bytes, unsigned box_bits = 8)
      : width_(width),
        box_bits_(box_bits),
        layout_(internal_layout(width)),
        lines_(bytes / traces::kNodeUnit + 1),
        leaf_index_(bytes / traces::kNodeUnit) {}

  unsigned width() const { return width_; }
  const InternalLayout& layout() const { return layout_; }
  const std::uint8_t* data() const { return lines_[0].bytes; }
  const std::uint8_t* node(std::uint64_t address) const { return data() + address; }
  std::uint64_t size() const { return (lines_.size() - 1) * traces::kNodeUnit; }

  /// Hands out the next `count` bytes (a multiple of 64); returns their address.
  std::uint64_t allocate(std::uint64_t count);
  std::uint64_t allocated() const { return used_; }

  void write_header(std::uint64_t address, std::uint64_t root, const Box& bounds);
  /// Encodes conservatively: every decoded box contains its ChildRecord's box (checked).
  void write_internal(std::uint64_t address, std::uint64_t child_base, const ChildRecord* children, unsigned count);
  void write_triangle(std::uint64_t address, std::uint32_t primitive, const glm::vec3& a, const glm::vec3& b,
                      const glm::vec3& c);
  /// to_unit, mean: of an ellipsoid in the world, where the ray must be transformed; a unit sphere of a BLAS has
  /// neither.
  void write_procedural(std::uint64_t address, std::uint32_t primitive, const glm::vec3* to_unit = nullptr,
                        const glm::vec3& mean = {});
  /// world_to_object: 3x3 rows; object_to_world: 3x3 columns and translation, as in the Xe instance leaf.
  void write_instance(std::uint64_t address, std::uint32_t instance, std::uint64_t blas_header, std::uint64_t blas_root,
                      const glm::vec3 (&world_to_object)[3], const glm::vec3 (&object_to_world)[3],
                      const glm::vec3& translation);

  DecodedInternal decode_internal(std::uint64_t address) const;
  std::uint32_t primitive(std::uint64_t leaf) const { return read_u32(leaf + 8); }  ///< triangle leaf
  /// Vertex 0..2 of a triangle leaf.
  glm::vec3 vertex(std::uint64_t leaf, unsigned index) const {
    glm::vec3 v;
    std::memcpy(&v, data() + leaf + 16 + 12 * std::uint64_t{index}, sizeof v);
    return v;
  }
  std::uint32_t procedural_primitive(std::uint64_t leaf) const { return read_u32(leaf + 12); }
  std::uint32_t instance_index(std::uint64_t leaf) const { return read_u32(leaf + 76); }
  /// What a leaf holds, primitive or instance, by its address in units: the same numbers as in the leaves' bytes, but
  /// close together. A tracer that only needs them touches a sixteenth of the memory.
  std::uint32_t leaf_index(std::uint32_t units) const { return leaf_index_[units]; }
  const std::uint32_t* leaf_indices() const { return leaf_index_.data(); }
  /// Tells the caches that the children at `child_base` (units) are needed soon, as nodes or as leaves. All of them,
  /// whether a ray meets them or not: the rays that follow meet others.
  void prefetch_children(std::uint32_t child_base) const {
    const std::uint8_t* const first = data() + std::uint64_t{child_base} * traces::kNodeUnit;
    for (unsigned i = 0; i < 6; ++i) __builtin_prefetch(first + i * traces::kNodeUnit);
    __builtin_prefetch(leaf_indices() + child_base);
    __builtin_prefetch(leaf_indices() + child_base + 16);  // children of the first of them often lie there
  }
  std::uint32_t read_u32(std::uint64_t address) const {
    std::uint32_t value = 0;
    std::memcpy(&value, data() + address, sizeof value);
    return value;
  }

 private:
  struct alignas(64) Line {
    std::uint8_t bytes[64];
  };

  std::uint8_t* at(std::uint64_t address) { return lines_[0].bytes + address; }

  unsigned width_;
  unsigned box_bits_;
  InternalLayout layout_;
  ZeroedPages<Line> lines_;  // one more than the image: vector loads of a node's last bounds may read past its end
  ZeroedPages<std::uint32_t> leaf_index_;
  std::uint64_t used_ = 0;
};

}  // namespace grtx::frontend
