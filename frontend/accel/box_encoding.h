// SPDX-License-Identifier: Apache-2.0
// Conservative 8-bit boxes of a node's children, as a node of the image stores them. docs/model/node-image.md.
#pragma once

#include <cstdint>

#include "grtx/frontend/gaussian/slab_intersection.h"
#include "grtx/traces/node_layout.h"

namespace grtx::frontend {

/// A child of an internal node before encoding.
struct ChildRecord {
  Box box;
  traces::NodeKind kind = traces::NodeKind::internal;
};

/// 2^(exponent - 8) as fp32 (exponents reach below the normal range for tiny boxes), -128 <= exponent <= 127.
float box_step(int exponent);

/// The coordinate that the decoder computes from a code.
inline float decode_bound(float origin, std::uint8_t code, float step) {
  return origin + static_cast<float>(code) * step;
}

/// Codes of the boxes of a node's children, axis by axis.
struct BoxCodes {
  float origin[3];
  std::int8_t exponent[3];
  std::uint8_t lower[3][traces::kMaxWidth];
  std::uint8_t upper[3][traces::kMaxWidth];
};

/// Finds on each axis the smallest exponent with which all boxes fit into `bits` bits (2..8) after outward rounding,
/// checked with the decoder's own arithmetic; codes are multiples of 2^(8 - bits). count: 1..8; boxes are finite and
/// not empty. Throws std::overflow_error when no exponent is large enough for an extent. Entries from `count` on are
/// not set.
void encode_boxes(const ChildRecord* children, unsigned count, unsigned bits, BoxCodes& codes);

}  // namespace grtx::frontend
