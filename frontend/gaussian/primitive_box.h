// SPDX-License-Identifier: Apache-2.0
// A primitive's box in the builder's format, RTCBuildPrimitive: two vectors of four floats.
#pragma once

#include <cstdint>

#include "grtx/frontend/gaussian/slab_intersection.h"

namespace grtx::frontend {

struct alignas(32) PrimitiveBox {
  float lower[3];
  std::uint32_t geometry;
  float upper[3];
  std::uint32_t primitive;

  PrimitiveBox() = default;
  explicit PrimitiveBox(const Box& b)
      : lower{b.lower.x, b.lower.y, b.lower.z}, geometry(0), upper{b.upper.x, b.upper.y, b.upper.z}, primitive(0) {}
  Box box() const {
    Box b;
    b.lower = {lower[0], lower[1], lower[2]};
    b.upper = {upper[0], upper[1], upper[2]};
    return b;
  }
};
static_assert(sizeof(PrimitiveBox) == 32);

}  // namespace grtx::frontend
