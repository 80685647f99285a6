// SPDX-License-Identifier: Apache-2.0
// Child offsets and masks that follow from the kinds of a node's children. The nodes of a tree share few shapes, so
// each is computed once and cached.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "grtx/traces/event.h"

namespace grtx::traces {

struct NodeShape {
  std::uint32_t offsets = 0;  ///< 4 bits per slot: address of the child - child base, units
  std::uint8_t child_count = 0;
  std::uint8_t internal_mask = 0;  ///< slots with an internal node
  std::uint8_t instance_mask = 0;  ///< slots with an instance leaf
  std::uint8_t wide_mask = 0;      ///< slots that take two units
  std::uint8_t wide_leaves = 0;    ///< slots with a leaf of a wide kind
  std::uint8_t units = 0;          ///< total size of the children
  std::uint8_t code = 0;           ///< as in column node_shape
  std::uint32_t kinds_code = 0;    ///< as in column node_kinds, up to three bytes
  const char* fault = nullptr;     ///< the rule that the kinds break, or null
};

NodeShape make_shape(const NodeSizes& sizes, const std::array<NodeKind, kMaxWidth>& kinds, unsigned child_count);

/// Cache of shapes. Use one per thread.
class ShapeTable {
 public:
  using Kinds = std::array<NodeKind, kMaxWidth>;
  /// A shape with its encoding.
  struct Stored {
    std::uint32_t codes = kNoCodes;
    Kinds kinds{};
    NodeShape shape;
  };

  /// Sets the node sizes and clears the cache if they differ.
  void set_sizes(const NodeSizes& sizes);
  const NodeShape& shape_of(const NodeDefinition& node);
  /// Shape of a node with this byte of column node_shape and these of node_kinds; null if the encoding is invalid.
  const Stored* stored(unsigned code, unsigned kinds_code) {
    const std::uint32_t codes = code | kinds_code << 8;
    Stored& entry = stored_[slot_of(codes)];
    if (entry.codes != codes && !store(code, kinds_code, entry)) [[unlikely]]
      return nullptr;
    return &entry;
  }

 private:
  static constexpr unsigned kBits = 9;
  static constexpr std::uint32_t kNoCodes = 0xFFFFFFFF;
  struct Entry {
    std::uint64_t kinds = 0;
    std::uint64_t count = ~std::uint64_t{0};
    NodeShape shape;
  };
  static std::size_t slot_of(std::uint64_t key) {
    return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15ULL) >> (64 - kBits));
  }
  bool store(unsigned code, unsigned kinds_code, Stored& entry) const;

  NodeSizes sizes_{NodeLayout::vulkan_sim, 0};
  std::vector<Entry> entries_;
  std::vector<Stored> stored_;
};

/// [mask of children that take two units][offset from the child base in units]: slot of the child that begins there;
/// kMaxWidth if none does. Slots beyond the child count are taken as one unit.
inline constexpr std::array<std::array<std::uint8_t, 16>, 256> kSlotAtOffset = [] {
  std::array<std::array<std::uint8_t, 16>, 256> slots{};
  for (unsigned wide = 0; wide < 256; ++wide) {
    for (std::uint8_t& slot : slots[wide]) slot = kMaxWidth;
    unsigned offset = 0;
    for (unsigned slot = 0; slot < kMaxWidth; ++slot) {
      slots[wide][offset] = static_cast<std::uint8_t>(slot);
      offset += 1 + (wide >> slot & 1);
    }
  }
  return slots;
}();

/// [byte] number of bits set. A table, because std::popcount is a function call on baseline x86-64.
inline constexpr std::array<std::uint8_t, 256> kBitsOfByte = [] {
  std::array<std::uint8_t, 256> bits{};
  for (unsigned i = 1; i < 256; ++i) bits[i] = static_cast<std::uint8_t>(bits[i / 2] + (i & 1));
  return bits;
}();
constexpr bool has_one_bit(unsigned bits) { return bits != 0 && (bits & (bits - 1)) == 0; }
constexpr unsigned bits_of_byte(unsigned byte) { return kBitsOfByte[byte & 0xFF]; }

}  // namespace grtx::traces
