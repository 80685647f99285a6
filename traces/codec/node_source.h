// Where an encoder learns what the internal nodes of a structure are.
#pragma once

#include <cstdint>

#include "grtx/traces/event.h"

namespace grtx::traces {

/// Tells where the children of an internal node lie that a ray visited.
class NodeSource {
 public:
  virtual ~NodeSource() = default;
  /// Definition of the internal node at `address` (in units).
  virtual NodeDefinition define(std::uint32_t address) const = 0;
};

}  // namespace grtx::traces
