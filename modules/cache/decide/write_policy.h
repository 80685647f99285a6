// SPDX-License-Identifier: Apache-2.0
// The L1's write policy, used by its timed and by its functional path.
#pragma once

#include <array>
#include <cstdint>

#include "grtx/base/declare/named_enum.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

enum class WritePolicy : std::uint8_t { write_through, write_back };
constexpr auto enum_names(WritePolicy) { return names_in_order<WritePolicy>({"write_through", "write_back"}); }

/// Policy for the private regions of a ray or warp (is_private()). All other regions: write-through, no allocation.
struct PrivateWrites {
  WritePolicy policy = WritePolicy::write_through;
  bool allocate = false;

  void parameters(ParameterList& list) {
    list.add("private_writes", policy,
             "writes to buffers that belong to one ray or warp: checkpoint, eviction, k-buffer, stack",
             from_public("GPGPU-Sim: local memory is written back, global memory through"));
    list.add("private_allocate", allocate, "a private write whose line is absent allocates a line", kOurs);
  }
  struct Effect {
    bool keep = false;     ///< the sector is valid in the L1 afterwards; allocates a line if absent
    bool dirty = false;    ///< the sector is dirty: written back on eviction
    bool forward = false;  ///< the write goes on to the L2, which acknowledges it
  };
  /// Effect of writing a whole sector. present: its line is in the cache.
  constexpr Effect effect(Region region, bool present) const {
    if (!is_private(region)) return {false, false, true};
    const bool keep = allocate || (policy == WritePolicy::write_back && present);
    const bool dirty = keep && policy == WritePolicy::write_back;
    return {keep, dirty, !dirty};
  }
};

}  // namespace grtx::modules
