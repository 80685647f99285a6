// SPDX-License-Identifier: Apache-2.0
// What plain units tell each other.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/modules/messages/memory_request.h"
#include "grtx/traces/event.h"
#include "rtl_tlm/plain/channel.h"

namespace grtx::sim::plain {

using modules::Region;

inline constexpr std::uint64_t kSector = 32;
inline constexpr unsigned kLanes = 32;

/// A sector that is read or written, and on the way back its answer.
struct Access {
  std::uint64_t address = 0;
  Region region = Region::tlas;
  bool write = false;
  bool prefetch = false;
  std::uint64_t tag = 0;  ///< of the client
  unsigned client = 0;    ///< of the L1
  unsigned sm = 0;
};

struct Launch {
  const traces::RayGroup* group = nullptr;
  unsigned slot = 0;
};
struct WarpEnded {
  unsigned slot = 0;
};
struct TraceCall {
  const traces::RayGroup* group = nullptr;
  unsigned slot = 0, round = 0;
};
struct TraceDone {
  unsigned slot = 0, round = 0;
};
struct AnyHitBatch {
  struct Call {
    unsigned lane;
    traces::LeafOutcome outcome;
    unsigned shifts;
    std::uint64_t leaf;   ///< address of the node; bounded by opacity that of the instance that it is in, if it is
    unsigned hidden = 0;  ///< entries that leave
  };
  unsigned slot = 0, round = 0;
  std::vector<Call> calls;   ///< lowest lane first
  bool intersected = false;  ///< the intersection shader has seen them
};
struct AnyHitDone {
  unsigned slot = 0;
  std::vector<AnyHitBatch::Call> calls;
};
struct NodeFetchBatch {
  unsigned slot = 0;
  std::vector<std::uint64_t> fetches;  ///< numbers of the RT unit
  std::vector<Access> sectors;         ///< in order of issue
};
struct NodeFetchDone {
  std::vector<std::uint64_t> fetches;
};

/// Both ways between a client and the L1.
struct MemoryPort {
  Channel<Access> request, response;
};

}  // namespace grtx::sim::plain
