// SPDX-License-Identifier: Apache-2.0
// Source from which an encoder gets the internal nodes of an acceleration structure.
#pragma once

#include <cstdint>

#include "grtx/traces/event.h"

namespace grtx::traces {

/// Implemented by whoever has the node image, for example the tracer.
class NodeSource {
 public:
  virtual ~NodeSource() = default;
  /// Definition of the internal node at `address` (in units).
  virtual NodeDefinition define(std::uint32_t address) const = 0;
};

}  // namespace grtx::traces
