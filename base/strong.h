// SPDX-License-Identifier: Apache-2.0
// Names for integers with a meaning.
#pragma once

#include <cstdint>
#include <limits>

namespace grtx {

/// One bit per lane.
using LaneMask = std::uint64_t;
/// One bit per warp: per entry of a warp buffer, or per warp slot.
using WarpMask = std::uint64_t;
/// Clock cycles of a domain; the core domain unless stated otherwise.
using Cycle = std::uint64_t;
/// The cycle of what is not to happen.
inline constexpr Cycle kNever = std::numeric_limits<Cycle>::max();

}  // namespace grtx
