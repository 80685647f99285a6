// What RT unit and SIMT core tell each other when the shader cores fetch the nodes: an RT unit that only intersects.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/modules/messages/coalescer.h"
#include "grtx/modules/messages/warp_messages.h"

namespace grtx::modules {

/// Node fetches of one warp that its shader does together.
struct NodeFetchBatch {
  std::uint16_t slot = 0;
  std::uint16_t entry = 0;            ///< of the warp buffer, returned in NodeFetchDone
  LaneMask fetches = 0;               ///< by the lane that opened each
  std::vector<SectorAccess> sectors;  ///< of all of them, in order of issue
};

struct NodeFetchDone {
  std::uint16_t entry = 0;
  LaneMask fetches = 0;
};

}  // namespace grtx::modules
