// SPDX-License-Identifier: Apache-2.0
// Codes of child boxes against the plain loop: one child and axis at a time, in double precision, step by step.
#include "grtx/frontend/accel/box_encoding.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

namespace grtx::frontend {
namespace {

struct AxisCode {
  float origin = std::numeric_limits<float>::max();
  int exponent = -128;
  std::array<int, traces::kMaxWidth> lower{};
  std::array<int, traces::kMaxWidth> upper{};
};

AxisCode plain_codes(const ChildRecord* children, unsigned count, int axis, unsigned bits) {
  const int quantum = 1 << (8 - bits);
  AxisCode code;
  float highest = -std::numeric_limits<float>::max();
  for (unsigned i = 0; i < count; ++i) {
    code.origin = std::min(code.origin, children[i].box.lower[axis]);
    highest = std::max(highest, children[i].box.upper[axis]);
  }
  const double extent = static_cast<double>(highest) - static_cast<double>(code.origin);
  if (extent > 0.0) {
    std::frexp(extent, &code.exponent);
    code.exponent = std::max(code.exponent, -128);
  }
  for (;; ++code.exponent) {
    if (code.exponent > 127) throw std::overflow_error("does not fit");
    const float step = std::ldexp(1.0f, code.exponent - 8);
    bool fits = true;
    for (unsigned i = 0; i < count; ++i) {
      const float low = children[i].box.lower[axis], high = children[i].box.upper[axis];
      const auto place = [&](float at) {
        return (static_cast<double>(at) - static_cast<double>(code.origin)) / static_cast<double>(step);
      };
      int lower = static_cast<int>(std::floor(place(low)));
      int upper = static_cast<int>(std::ceil(place(high)));
      while (lower > 0 && code.origin + static_cast<float>(lower) * step > low) --lower;
      while (upper <= 255 && code.origin + static_cast<float>(upper) * step < high) ++upper;
      code.lower[i] = lower / quantum * quantum;
      code.upper[i] = (upper + quantum - 1) / quantum * quantum;
      fits = fits && code.upper[i] <= 256 - quantum;
    }
    if (fits) return code;
  }
}

void expect_plain_codes(const ChildRecord* children, unsigned count, unsigned bits) {
  BoxCodes codes{};
  encode_boxes(children, count, bits, codes);
  for (int axis = 0; axis < 3; ++axis) {
    const AxisCode plain = plain_codes(children, count, axis, bits);
    EXPECT_EQ(std::signbit(codes.origin[axis]), std::signbit(plain.origin));
    EXPECT_EQ(codes.origin[axis], plain.origin);
    EXPECT_EQ(int{codes.exponent[axis]}, plain.exponent);
    for (unsigned i = 0; i < count; ++i) {
      EXPECT_EQ(int{codes.lower[axis][i]}, plain.lower[i]);
      EXPECT_EQ(int{codes.upper[axis][i]}, plain.upper[i]);
    }
  }
}

TEST(BoxEncoding, CodesAreThoseOfThePlainLoop) {
  std::mt19937 engine(3);
  const auto uniform = [&](float low, float high) {
    return low + (high - low) * (static_cast<float>(engine() >> 8) / 16777216.0f);
  };
  for (int trial = 0; trial < 40000 && !testing::Test::HasFailure(); ++trial) {
    const unsigned count = 1 + engine() % traces::kMaxWidth;
    // From below the smallest step to most of the range; the centre far away, near, and in the boxes.
    const float extent = std::pow(10.0f, uniform(-44.0f, 35.0f));
    const float centre = trial % 4 == 0 ? 0.0f : extent * std::pow(10.0f, uniform(-2.0f, 7.0f)) * uniform(-1, 1);
    if (!std::isfinite(centre)) continue;
    ChildRecord children[traces::kMaxWidth];
    for (unsigned i = 0; i < count; ++i) {
      const auto point = [&] {
        return glm::vec3(centre) + glm::vec3{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)} * extent;
      };
      children[i].box.extend(point());
      if (engine() % 4 != 0) children[i].box.extend(point());
      // Whole steps and the very ends of the codes.
      if (engine() % 4 == 0)
        children[i].box.upper[0] = children[0].box.lower[0] + std::ldexp(1.0f, static_cast<int>(engine() % 9)) * extent;
      children[i].box.upper[0] = std::max(children[i].box.upper[0], children[i].box.lower[0]);
    }
    expect_plain_codes(children, count, 2 + static_cast<unsigned>(trial) % 7);
  }
}

TEST(BoxEncoding, CornersOfTheRange) {
  constexpr float kLeast = std::numeric_limits<float>::denorm_min();
  struct Case {
    float lower, upper;
  };
  for (const Case& c : {Case{0, 0}, Case{-0.0f, 0}, Case{0, kLeast}, Case{-kLeast, kLeast}, Case{0, 0x1p-128f},
                        Case{0, 0x1p-136f}, Case{0, 255}, Case{0, 256}, Case{1, 0x1.000002p0f}, Case{-1, 0x1p126f},
                        Case{0x1.fffffep126f, 0x1.fffffep126f}}) {
    for (unsigned bits = 2; bits <= 8; ++bits) {
      ChildRecord children[2];
      children[0].box.extend(glm::vec3(c.lower, c.lower, 1));
      children[1].box.extend(glm::vec3(c.upper, c.lower, 2));
      children[1].box.extend(glm::vec3(c.upper, c.upper, 2));
      expect_plain_codes(children, 2, bits);
    }
  }
}

TEST(BoxEncoding, BoxesBeyondTheExponentsAreRefused) {
  ChildRecord child;
  child.box.extend(glm::vec3(-0x1p127f));
  child.box.extend(glm::vec3(0x1p127f));
  BoxCodes codes{};
  EXPECT_THROW(encode_boxes(&child, 1, 8, codes), std::overflow_error);
  EXPECT_THROW(plain_codes(&child, 1, 0, 8), std::overflow_error);
}

}  // namespace
}  // namespace grtx::frontend
