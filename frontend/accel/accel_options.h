// SPDX-License-Identifier: Apache-2.0
// Which acceleration structure to build.
#pragma once

#include <string>

#include "grtx/traces/modes.h"

namespace grtx::frontend {

using traces::AccelKind;
using traces::NodeLayout;

AccelKind accel_from_name(const std::string& name);  ///< throws Error naming the nearest known name
/// Whether the tracer reads Gaussians as rounded in leaves of this layout; PreparedGaussians must then be quantised.
constexpr bool is_quantised(NodeLayout layout) { return layout == NodeLayout::quantised; }
std::string accel_name(AccelKind kind);

struct AccelOptions {
  AccelKind kind = AccelKind::tri20;
  unsigned width = 6;          ///< children per internal node, 2..8
  bool corner_bounds = false;  ///< instance boxes from the BLAS box's eight corners (as drivers do) instead of tight
  unsigned box_bits = 8;       ///< bits used of a stored box coordinate, 2..8
  NodeLayout layout = NodeLayout::vulkan_sim;
  friend bool operator==(const AccelOptions&, const AccelOptions&) = default;
};

}  // namespace grtx::frontend
