// SPDX-License-Identifier: Apache-2.0
// Messages between RT unit and SIMT core if the shaders fetch the nodes and the RT unit only intersects.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/modules/messages/coalescer.h"
#include "grtx/modules/messages/warp_messages.h"

namespace grtx::modules {

/// Node fetches of one warp that its shader executes together.
struct NodeFetchBatch {
  std::uint16_t slot = 0;
  std::uint16_t entry = 0;            ///< warp buffer entry, returned in NodeFetchDone
  LaneMask fetches = 0;               ///< one bit per fetch: the lane that opened it
  std::vector<SectorAccess> sectors;  ///< sectors of all fetches, in issue order
};

struct NodeFetchDone {
  std::uint16_t entry = 0;
  LaneMask fetches = 0;
};

}  // namespace grtx::modules
