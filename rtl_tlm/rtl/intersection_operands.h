// What a trace does not hold: the numbers that a ray-box or a ray-transform unit works on, made as a function of ray,
// visit and test, and what the host's fp32 arithmetic makes of them, in the tracer's order of operations. The bridges
// hold the RTL against it; tests hold it against the tracer.
#pragma once

#include <array>
#include <cstdint>

namespace grtx::sim {

/// Mixes a number's bits (SplitMix64).
constexpr std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

using Float3 = std::array<float, 3>;

/// 1/d as the tracer's slab tests take it: what is no finite number is the largest one with the sign of d.
float reciprocal_for_slabs(float d);

inline constexpr unsigned kMostBoxes = 8;

/// A ray and the boxes of a node's children.
struct BoxOperands {
  Float3 origin, inverse;  ///< inverse: of the direction
  float t_offset, t_min, t_max;
  unsigned used;  ///< mask of children
  std::array<Float3, kMostBoxes> lower, upper;
};

/// A hit child. Its box is entered no earlier than t; beyond: and not before t_max.
struct BoxChild {
  std::uint32_t t;  ///< bits of an fp32 number that is not below zero
  unsigned slot;
  bool beyond;
  friend bool operator==(const BoxChild&, const BoxChild&) = default;
};

struct BoxOutcome {
  unsigned hits = 0;                         ///< how many
  std::array<BoxChild, kMostBoxes> order{};  ///< by t, then slot
};

BoxOutcome box_outcome(const BoxOperands& operands);

/// A ray and a 3 x 4 matrix.
struct TransformOperands {
  std::array<Float3, 3> rows;
  Float3 translation, origin, direction;
};

struct TransformOutcome {
  Float3 origin, direction, inverse;
};

TransformOutcome transform_outcome(const TransformOperands& operands);

/// Ordinary rays, rays that touch boxes and boxes that touch one another, and numbers of every kind: zeros of both
/// signs, subnormal ones, infinities, NaN. boxes: 1 to that many children.
BoxOperands made_box_operands(std::uint64_t seed, unsigned boxes);
TransformOperands made_transform_operands(std::uint64_t seed);

/// Equal bits, or both no number: which NaN an operation gives, processors decide differently.
bool same_number(float a, float b);

}  // namespace grtx::sim
