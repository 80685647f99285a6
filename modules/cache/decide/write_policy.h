// What a write does to the L1. The L1 asks here, with and without time.
#pragma once

#include <array>
#include <cstdint>

#include "grtx/base/declare/named_enum.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

enum class WritePolicy : std::uint8_t { write_through, write_back };
constexpr auto enum_names(WritePolicy) { return names_in_order<WritePolicy>({"write_through", "write_back"}); }

/// What holds for regions of one ray or warp (is_private()); all others are written through, without allocation.
struct PrivateWrites {
  WritePolicy policy = WritePolicy::write_through;
  bool allocate = false;

  void parameters(ParameterList& list) {
    list.add("private_writes", policy,
             "writes to buffers that belong to one ray or warp: checkpoint, eviction, k-buffer, stack",
             from_public("GPGPU-Sim: local memory is written back, global memory through"))
        .came_later();
    list.add("private_allocate", allocate, "a private write whose line is absent takes a line", kOurs).came_later();
  }
  struct Effect {
    bool keep = false;     ///< the sector is valid in the L1 afterwards, in a new line if need be
    bool dirty = false;    ///< and has to be written back when its line goes
    bool forward = false;  ///< it goes on to the L2, which acknowledges it
  };
  /// What the write of a whole sector does; present: its line is in the cache.
  constexpr Effect effect(Region region, bool present) const {
    if (!is_private(region)) return {false, false, true};
    const bool keep = allocate || (policy == WritePolicy::write_back && present);
    const bool dirty = keep && policy == WritePolicy::write_back;
    return {keep, dirty, !dirty};
  }
};

}  // namespace grtx::modules
