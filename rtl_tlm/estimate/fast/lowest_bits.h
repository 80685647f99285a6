// A mask of the first places of an SM.
#pragma once

#include "grtx/modules/messages/lane_loop.h"

namespace grtx::sim::fast {

/// bits: at most 64.
constexpr LaneMask lowest_bits(unsigned bits) { return bits >= 64 ? ~LaneMask{0} : modules::bit(bits) - 1; }

}  // namespace grtx::sim::fast
