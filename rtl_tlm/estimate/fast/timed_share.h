// Fast mode in which one in so many events takes time: what was counted of those, for all of them.
#pragma once

#include <cstdint>

#include "grtx/modules/cache/l1_cache.h"
#include "grtx/modules/cache/l2_slice.h"
#include "grtx/modules/dram/dram.h"
#include "grtx/modules/rt_unit/rt_unit.h"
#include "grtx/modules/simt/simt_counters.h"

namespace grtx::sim::fast {

/// Any-hit and intersection shaders, and their memory instructions.
struct AnyHitWork {
  std::uint64_t batches = 0, intersections = 0, loads = 0, stores = 0;
};

// Each makes 2^doublings times as much of what only timed events count. What is counted of all events (what the trace
// gives) stays as it is, and so does what is a maximum.
void scale_up(modules::RtUnitCounters& c, unsigned doublings);
/// timed, warming: the any-hit shaders of timed events and of others; c has both.
void scale_up(modules::SimtCounters& c, unsigned doublings, const AnyHitWork& timed, const AnyHitWork& warming);
void scale_up(modules::L1Counters& c, unsigned doublings);
void scale_up(modules::L2Counters& c, unsigned doublings);
void scale_up(modules::DramChannelCounters& c, unsigned doublings);

}  // namespace grtx::sim::fast
