// SPDX-License-Identifier: Apache-2.0
// Names for integers with a meaning.
#pragma once

#include <cstdint>

namespace grtx {

/// One bit per lane (or per warp buffer entry or warp slot).
using LaneMask = std::uint64_t;
/// Clock cycles of a domain; the core domain unless stated otherwise.
using Cycle = std::uint64_t;

}  // namespace grtx
