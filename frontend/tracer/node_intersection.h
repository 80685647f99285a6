// SPDX-License-Identifier: Apache-2.0
// Tests a ray against all children of an internal node at once, straight from the quantised bytes, and orders the hit
// ones by where the ray enters them. Runs on the vector instructions of frontend/gaussian/simd_path.h.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "grtx/frontend/accel/node_image.h"
#include "grtx/frontend/gaussian/simd_path.h"
#include "grtx/frontend/gaussian/slab_intersection.h"

namespace grtx::frontend {

/// 2^(e - 8) for the signed exponent byte e.
inline const std::array<float, 256> kExponentStep = [] {
  std::array<float, 256> steps{};
  for (int e = -128; e < 128; ++e) steps[static_cast<std::uint8_t>(e)] = std::ldexp(1.0f, e - 8);
  return steps;
}();

struct ChildInfo {
  unsigned valid = 0;            ///< mask of used slots
  unsigned wide = 0;             ///< mask of children that take two units
  std::uint32_t child_base = 0;  ///< units
};

/// Byte i: number of two-unit children before slot i; indexed by the mask of such children.
inline constexpr std::array<std::uint64_t, 256> kWideBefore = [] {
  std::array<std::uint64_t, 256> before{};
  for (unsigned mask = 0; mask < 256; ++mask) {
    std::uint64_t count = 0;
    for (unsigned slot = 0; slot < 8; ++slot) {
      before[mask] |= count << (8 * slot);
      count += mask >> slot & 1;
    }
  }
  return before;
}();

/// Offset of a child from the child base, in units.
inline std::uint32_t child_offset(const ChildInfo& info, unsigned slot) {
  return slot + static_cast<std::uint32_t>(kWideBefore[info.wide] >> (8 * slot) & 0xFF);
}

/// Inputs of a node test besides node and ray.
struct NodeQuery {
  float t_offset = 0.0f;  ///< added to slab parameters: 0 in world space, t_peak in a Gaussian's unit space
  float t_min = 0.0f;     ///< boxes that end before it do not count as hit
};

struct alignas(32) NodeHits {
  float enter[8];        ///< conservative entry t
  float exit[8];         ///< conservative exit t
  std::int32_t rank[8];  ///< of a hit slot: number of hit slots before it in the order (enter, slot)
  unsigned hit = 0;      ///< mask of hit children
  unsigned count = 0;    ///< bits of `hit`
  ChildInfo info;
};

/// node: bytes in the image; address: its address, units. Children count as hit when their conservative interval is not
/// empty and does not end before t_min.
using NodeTest = void (*)(const std::uint8_t* node, std::uint32_t address, const SlabRay& ray, const NodeQuery& query,
                          NodeHits& hits);

/// Layout of nodes as a compile-time constant.
template <unsigned slots, bool packed>
struct NodeForm {
  static constexpr unsigned kSlots = slots;
  static constexpr bool kPacked = packed;
  static constexpr InternalLayout kLayout = packed ? InternalLayout{8, 16, 22, true} : internal_layout(slots);
};
/// Calls f(NodeForm) for nodes of this layout and returns what it returns.
template <typename F>
auto with_node_form(const InternalLayout& layout, const F& f) {
  if (layout.packed) return f(NodeForm<8, true>{});
  return layout.slots == 6 ? f(NodeForm<6, false>{}) : f(NodeForm<8, false>{});
}

/// The test for nodes of a layout. The path must be available.
NodeTest node_test(SimdPath path, const InternalLayout& layout);
/// The same for callers that do not need `rank`, which it may leave unset.
NodeTest node_test_unordered(SimdPath path, const InternalLayout& layout);

}  // namespace grtx::frontend
