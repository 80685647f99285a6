// What whole numbers mean.
#pragma once

#include <cstdint>

namespace grtx {

/// One bit a lane.
using LaneMask = std::uint64_t;
/// Clock cycles of the domain that the context names (core unless said).
using Cycle = std::uint64_t;

}  // namespace grtx
