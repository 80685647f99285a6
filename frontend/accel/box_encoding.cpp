// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/accel/box_encoding.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "grtx/frontend/gaussian/float4.h"

namespace grtx::frontend {
namespace {

using Double4 [[gnu::vector_size(32)]] = double;
using Int4 [[gnu::vector_size(16)]] = std::int32_t;

constexpr float kLargest = std::numeric_limits<float>::max();
constexpr int kLeastExponent = -128;
constexpr int kMostExponent = 127;

// The exponent e of a normal number in [2^(e - 1), 2^e), as std::frexp gives it. Differences of floats are normal
// doubles.
int exponent_of(double positive) { return static_cast<int>(std::bit_cast<std::uint64_t>(positive) >> 52) - 1022; }

// 2^n, |n| <= 1022.
double power_of_two(int n) { return std::bit_cast<double>(static_cast<std::uint64_t>(n + 1023) << 52); }

bool holds(Int4 mask) { return (mask[0] & mask[1] & mask[2]) != 0; }

}  // namespace

float box_step(int exponent) { return static_cast<float>(power_of_two(exponent - 8)); }

// One lane per axis. Division by a step, a power of two, is exact as multiplication by the reciprocal, and both stay
// normal doubles; positions are not negative, so conversion to int is floor.
void encode_boxes(const ChildRecord* children, unsigned count, unsigned bits, BoxCodes& codes) {
  const int quantum = 1 << (8 - bits);
  Float4 lower[traces::kMaxWidth], upper[traces::kMaxWidth];
  Float4 origin = {kLargest, kLargest, kLargest, 0};
  Float4 highest = {-kLargest, -kLargest, -kLargest, 0};
  for (unsigned i = 0; i < count; ++i) {
    const Box& box = children[i].box;
    lower[i] = Float4{box.lower.x, box.lower.y, box.lower.z, 0};
    upper[i] = Float4{box.upper.x, box.upper.y, box.upper.z, 0};
    origin = min(lower[i], origin);
    highest = max(upper[i], highest);
  }
  const auto exact_origin = __builtin_convertvector(origin, Double4);
  const Double4 extent = __builtin_convertvector(highest, Double4) - exact_origin;
  int exponent[3];
  for (int axis = 0; axis < 3; ++axis) {
    exponent[axis] = extent[axis] > 0.0 ? std::max(exponent_of(extent[axis]), kLeastExponent) : kLeastExponent;
  }
  for (bool fit = false; !fit;) {
    Float4 step = {0, 0, 0, 0};
    Double4 reciprocal = {0, 0, 0, 0};
    for (int axis = 0; axis < 3; ++axis) {
      if (exponent[axis] > kMostExponent) throw std::overflow_error("child box does not fit the encoding");
      step[axis] = box_step(exponent[axis]);
      reciprocal[axis] = power_of_two(8 - exponent[axis]);
    }
    Int4 most = {0, 0, 0, 0};
    for (unsigned i = 0; i < count; ++i) {
      const Double4 low = (__builtin_convertvector(lower[i], Double4) - exact_origin) * reciprocal;
      const Double4 high = (__builtin_convertvector(upper[i], Double4) - exact_origin) * reciprocal;
      Int4 first = __builtin_convertvector(low, Int4);
      Int4 last = __builtin_convertvector(high, Int4);
      last -= __builtin_convertvector(__builtin_convertvector(last, Double4) < high, Int4);  // a true lane is -1: ceil
      first &= -quantum;
      last = (last + (quantum - 1)) & -quantum;
      assert(holds((origin + __builtin_convertvector(first, Float4) * step <= lower[i]) &
                   (origin + __builtin_convertvector(last, Float4) * step >= upper[i])));
      most = last > most ? last : most;
      for (int axis = 0; axis < 3; ++axis) {
        codes.lower[axis][i] = static_cast<std::uint8_t>(first[axis]);
        codes.upper[axis][i] = static_cast<std::uint8_t>(last[axis]);
      }
    }
    fit = true;
    for (int axis = 0; axis < 3; ++axis) {
      if (most[axis] <= 256 - quantum) continue;
      ++exponent[axis];
      fit = false;
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    codes.origin[axis] = origin[axis];
    codes.exponent[axis] = static_cast<std::int8_t>(exponent[axis]);
  }
}

}  // namespace grtx::frontend
