// SPDX-License-Identifier: Apache-2.0
// Test operands for the RTL ray-box and ray-transform units, since a trace does not contain them: generated from ray,
// visit and test, with reference results in the host's fp32 arithmetic, in the tracer's order of operations. The
// bridges check the RTL against these; tests check these against the tracer.
#pragma once

#include <array>
#include <cstdint>

namespace grtx::sim {

using Float3 = std::array<float, 3>;

/// 1/d as in the tracer's slab tests: a result that is not finite is replaced by the largest float with the sign of d.
float reciprocal_for_slabs(float d);

inline constexpr unsigned kMostBoxes = 8;

/// A ray and the boxes of a node's children.
struct BoxOperands {
  Float3 origin, inverse;  ///< inverse: reciprocal of the direction
  float t_offset, t_min, t_max;
  unsigned used;  ///< mask of children
  std::array<Float3, kMostBoxes> lower, upper;
};

/// A hit child, whose box is entered at t or later. beyond: not before t_max.
struct BoxChild {
  std::uint32_t t;  ///< bits of a non-negative fp32 number
  unsigned slot;
  bool beyond;
  friend bool operator==(const BoxChild&, const BoxChild&) = default;
};

struct BoxOutcome {
  unsigned hits = 0;                         ///< number of hit children
  std::array<BoxChild, kMostBoxes> order{};  ///< hit children, sorted by t, then slot
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

/// Random operands: ordinary rays, rays that touch boxes, boxes that touch each other, and special values: zeros of
/// both signs, subnormals, infinities, NaN. boxes: most children; 1 to that many are used.
BoxOperands made_box_operands(std::uint64_t seed, unsigned boxes);
TransformOperands made_transform_operands(std::uint64_t seed);

/// Whether a and b have equal bits or are both NaN: the NaN that an operation returns depends on the processor.
bool same_number(float a, float b);

}  // namespace grtx::sim
