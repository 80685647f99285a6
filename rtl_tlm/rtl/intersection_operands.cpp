// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/rtl/intersection_operands.h"

#include <bit>
#include <cmath>
#include <limits>

#include "grtx/base/split_mix.h"

namespace grtx::sim {
namespace {

constexpr float kLargest = std::numeric_limits<float>::max();

/// A pseudo-random sequence of numbers.
class Numbers {
 public:
  explicit Numbers(std::uint64_t seed) : state_(split_mix(seed)) {}

  std::uint64_t next() { return state_ = split_mix(state_); }
  unsigned below(unsigned n) { return static_cast<unsigned>(next() >> 32) % n; }

  /// Magnitude between 2^-20 and 2^20.
  float ordinary() {
    const std::uint64_t r = next();
    return with(r, 107 + static_cast<std::uint32_t>(r >> 40) % 40);
  }
  float any_bits() { return std::bit_cast<float>(static_cast<std::uint32_t>(next() >> 16)); }
  /// Any kind of number, including zeros, subnormals, infinities and NaNs.
  float special() {
    const std::uint64_t r = next();
    const auto sign = static_cast<std::uint32_t>(r) & 0x80000000u;
    const auto fraction = static_cast<std::uint32_t>(r >> 33) & 0x7fffffu;
    switch ((r >> 24) % 9) {
      case 0:
        return std::bit_cast<float>(sign);
      case 1:
        return std::bit_cast<float>(sign | fraction);
      case 2:
        return std::bit_cast<float>(sign | (fraction & 0xfu));
      case 3:
        return std::bit_cast<float>(sign | 0x7f800000u);
      case 4:
        return std::bit_cast<float>(sign | 0x7f800000u | fraction);
      case 5:
        return with(r, 254 - static_cast<std::uint32_t>(r >> 57) % 3);
      case 6:
        return with(r, 1 + static_cast<std::uint32_t>(r >> 57) % 24);
      case 7:
        return std::bit_cast<float>(sign | 0x3f800000u);
      default:
        return any_bits();
    }
  }
  /// One of few values, so that ties occur: multiples of 1/4 from -2 to 2, zeros of both signs.
  float on_grid() {
    const unsigned k = below(18);
    return k == 17 ? -0.0f : (static_cast<float>(k) - 8.0f) * 0.25f;
  }
  /// A power of two, or the value that replaces 1/0.
  float on_grid_inverse() {
    const std::uint64_t r = next();
    const float size = (r >> 8) % 6 == 0 ? kLargest : std::ldexp(1.0f, static_cast<int>((r >> 16) % 3) - 1);
    return (r >> 32 & 1) != 0 ? -size : size;
  }

 private:
  static float with(std::uint64_t r, std::uint32_t exponent) {
    return std::bit_cast<float>((static_cast<std::uint32_t>(r) & 0x807fffffu) | exponent << 23);
  }
  std::uint64_t state_;
};

float sum_of_products(const Float3& a, const Float3& b) { return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]; }

}  // namespace

bool same_number(float a, float b) {
  return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b) || (std::isnan(a) && std::isnan(b));
}

float reciprocal_for_slabs(float d) {
  const float inverse = 1.0f / d;
  return std::fabs(inverse) <= kLargest ? inverse : std::copysign(kLargest, d);
}

BoxOutcome box_outcome(const BoxOperands& operands) {
  // 2 gamma(3): Ize, "Robust BVH Ray Traversal", JCGT 2013.
  constexpr float kSlack = 2.0f * (3.0f * 5.9604645e-8f) / (1.0f - 3.0f * 5.9604645e-8f);
  BoxOutcome outcome;
  for (unsigned slot = 0; slot < kMostBoxes; ++slot) {
    if ((operands.used >> slot & 1) == 0) continue;
    float near = 0.0f, far = 0.0f;
    for (unsigned axis = 0; axis < 3; ++axis) {
      const bool negative = std::signbit(operands.inverse[axis]);
      const float lower = operands.lower[slot][axis], upper = operands.upper[slot][axis];
      const float a = ((negative ? upper : lower) - operands.origin[axis]) * operands.inverse[axis];
      const float b = ((negative ? lower : upper) - operands.origin[axis]) * operands.inverse[axis];
      near = axis == 0 || !(near > a) ? a : near;
      far = axis == 0 || !(far < b) ? b : far;
    }
    float enter = near + operands.t_offset;
    enter = (enter > 0.0f ? enter : 0.0f) * (1.0f - kSlack);
    const float exit = (far + operands.t_offset) * (1.0f + kSlack);
    if (!(enter <= exit && exit >= operands.t_min)) continue;
    const BoxChild child{std::bit_cast<std::uint32_t>(enter), slot, !(enter <= operands.t_max)};
    unsigned place = outcome.hits++;
    for (; place > 0 && child.t < outcome.order[place - 1].t; --place) outcome.order[place] = outcome.order[place - 1];
    outcome.order[place] = child;
  }
  return outcome;
}

TransformOutcome transform_outcome(const TransformOperands& operands) {
  TransformOutcome outcome;
  for (unsigned i = 0; i < 3; ++i) {
    const Float3& row = operands.rows[i];
    outcome.origin[i] = (row[0] * operands.origin[0] + row[1] * operands.origin[1]) +
                        (row[2] * operands.origin[2] + operands.translation[i]);
    outcome.direction[i] = sum_of_products(row, operands.direction);
    outcome.inverse[i] = reciprocal_for_slabs(outcome.direction[i]);
  }
  return outcome;
}

BoxOperands made_box_operands(std::uint64_t seed, unsigned boxes) {
  Numbers numbers(seed);
  const unsigned kind = numbers.below(8);
  const auto number = [&](bool inverse) {
    switch (kind) {
      case 0:
        return numbers.any_bits();
      case 1:
        return numbers.special();
      case 2:
        return numbers.below(4) == 0 ? numbers.special() : numbers.on_grid();
      case 3:
      case 4:
        return inverse ? numbers.on_grid_inverse() : numbers.on_grid();
      default:
        return numbers.ordinary();
    }
  };
  BoxOperands operands{};
  for (float& x : operands.origin) x = number(false);
  for (float& x : operands.inverse) {
    x = number(true);
    if (kind != 0 && numbers.below(2) == 0) x = reciprocal_for_slabs(x);
  }
  operands.t_offset = numbers.below(2) == 0 ? 0.0f : number(false);
  operands.t_min = numbers.below(2) == 0 ? 0.0f : number(false);
  operands.t_max = numbers.below(2) == 0 ? std::numeric_limits<float>::infinity() : std::fabs(number(false));
  const unsigned children = boxes == 1 ? 1 : 1 + numbers.below(boxes);
  operands.used = (1u << children) - 1;
  for (unsigned slot = 0; slot < children; ++slot) {
    for (unsigned axis = 0; axis < 3; ++axis) {
      float a = number(false), b = number(false);
      // Valid boxes as in a BVH; half of them on the ray's path.
      if (kind >= 3 && b < a) std::swap(a, b);
      if (kind >= 5 && numbers.below(2) == 0) {
        const float size = std::fabs(b), on_ray = operands.origin[axis] + 4.0f / operands.inverse[axis];
        a = on_ray - size;
        b = on_ray + size;
      }
      operands.lower[slot][axis] = a;
      operands.upper[slot][axis] = b;
    }
    if (slot > 0 && numbers.below(6) == 0) {  // repeat the previous box: a tie, resolved by slot
      operands.lower[slot] = operands.lower[slot - 1];
      operands.upper[slot] = operands.upper[slot - 1];
    }
  }
  return operands;
}

TransformOperands made_transform_operands(std::uint64_t seed) {
  Numbers numbers(seed);
  const unsigned kind = numbers.below(4);
  const auto number = [&] {
    switch (kind) {
      case 0:
        return numbers.any_bits();
      case 1:
        return numbers.below(3) == 0 ? numbers.special() : numbers.on_grid();
      case 2:
        return numbers.below(8) == 0 ? numbers.special() : numbers.ordinary();
      default:
        return numbers.ordinary();
    }
  };
  TransformOperands operands{};
  for (Float3& row : operands.rows) {
    for (float& x : row) x = number();
  }
  for (Float3* vector : {&operands.translation, &operands.origin, &operands.direction}) {
    for (float& x : *vector) x = number();
  }
  if (numbers.below(4) == 0) {  // products that cancel, and a direction parallel to an axis
    operands.rows[0][1] = operands.rows[0][0];
    operands.direction[1] = -operands.direction[0];
    operands.direction[2] = numbers.below(2) == 0 ? 0.0f : -0.0f;
  }
  return operands;
}

}  // namespace grtx::sim
