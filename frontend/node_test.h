// Tests a ray against all children of an internal node at once, straight from the quantised bytes.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "frontend/node_image.h"
#include "frontend/slab_test.h"

namespace grtx::frontend {

/// Eight floats; GCC and Clang lower it to whatever the target has.
using Float8 = float __attribute__((vector_size(32)));
using Int8 = std::int32_t __attribute__((vector_size(32)));
using Byte8 = std::uint8_t __attribute__((vector_size(8)));

/// 2^(e - 8) for the signed exponent byte e.
inline const std::array<float, 256> kExponentStep = [] {
  std::array<float, 256> steps{};
  for (int e = -128; e < 128; ++e) steps[static_cast<std::uint8_t>(e)] = std::ldexp(1.0f, e - 8);
  return steps;
}();

struct ChildInfo {
  unsigned valid = 0;     ///< mask of used slots
  unsigned wide = 0;      ///< mask of children that take two units
  unsigned internal = 0;  ///< mask of internal children
  std::uint32_t child_base = 0;  ///< units
};

/// Gathers bit 0 of each byte of `x` into the low 8 bits.
constexpr unsigned gather_low_bits(std::uint64_t x) {
  return static_cast<unsigned>(((x & 0x0101010101010101ull) * 0x0102040810204080ull) >> 56);
}

inline ChildInfo child_info(const std::uint8_t* node, std::uint32_t address_units, const InternalLayout& layout) {
  std::uint64_t info = 0;
  std::memcpy(&info, node + layout.child_info, 8);
  std::int32_t offset = 0;
  std::memcpy(&offset, node + 12, 4);
  const unsigned slots = (1u << layout.slots) - 1u;
  ChildInfo result;
  const unsigned one = gather_low_bits(info), two = gather_low_bits(info >> 1);
  result.valid = (one | two) & slots;
  result.wide = two & slots;
  result.internal = ~(gather_low_bits(info >> 2) | gather_low_bits(info >> 3) | gather_low_bits(info >> 4)) & result.valid;
  result.child_base = address_units + static_cast<std::uint32_t>(offset);
  return result;
}

// By reference: passing wide vectors by value has no stable ABI without AVX.
inline void take_max(Float8& a, const Float8& b) { a = a > b ? a : b; }
inline void take_min(Float8& a, const Float8& b) { a = a < b ? a : b; }

inline unsigned mask_of(const Int8& m) {
#if defined(__SSE2__)
  __m128 halves[2];
  std::memcpy(halves, &m, sizeof halves);
  return static_cast<unsigned>(_mm_movemask_ps(halves[0])) | (static_cast<unsigned>(_mm_movemask_ps(halves[1])) << 4);
#else
  unsigned mask = 0;
  for (int i = 0; i < 8; ++i) mask |= (m[i] != 0 ? 1u : 0u) << i;
  return mask;
#endif
}

/// Children whose conservative interval is not empty and does not end before t_min. enter[i]: conservative entry t.
/// t_offset is added to slab parameters: 0 in world space, t_peak in a Gaussian's unit space.
inline unsigned test_children(const std::uint8_t* node, const InternalLayout& layout, const SlabRay& ray,
                              float t_offset, float t_min, float (&enter)[8]) {
  Float8 near_t{}, far_t{};
  for (int axis = 0; axis < 3; ++axis) {
    float origin = 0.0f;
    std::memcpy(&origin, node + 4 * axis, 4);
    const float step = kExponentStep[node[18 + axis]];
    const std::uint8_t* lower = node + layout.bounds + 2 * static_cast<unsigned>(axis) * layout.slots;
    const std::uint8_t* upper = lower + layout.slots;
    Byte8 near_bytes, far_bytes;
    std::memcpy(&near_bytes, ray.negative[axis] ? upper : lower, 8);
    std::memcpy(&far_bytes, ray.negative[axis] ? lower : upper, 8);
    const Float8 near_bound = origin + __builtin_convertvector(near_bytes, Float8) * step;
    const Float8 far_bound = origin + __builtin_convertvector(far_bytes, Float8) * step;
    const Float8 a = (near_bound - ray.origin[axis]) * ray.inverse[axis];
    const Float8 b = (far_bound - ray.origin[axis]) * ray.inverse[axis];
    if (axis == 0) {
      near_t = a;
      far_t = b;
    } else {
      take_max(near_t, a);
      take_min(far_t, b);
    }
  }
  near_t += t_offset;
  take_max(near_t, Float8{});
  near_t *= 1.0f - kSlabSlack;
  far_t = (far_t + t_offset) * (1.0f + kSlabSlack);
  std::memcpy(enter, &near_t, sizeof near_t);
  return mask_of((near_t <= far_t) & (far_t >= t_min));
}

}  // namespace grtx::frontend
