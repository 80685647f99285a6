// SPDX-License-Identifier: Apache-2.0
// Memory that decoded groups take: a small file may decode to very much.
#pragma once

#include <cstdint>

#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::traces {

/// Bytes of a group's array elements.
inline std::uint64_t decoded_bytes(const RayGroup& group) {
  std::uint64_t sum = group.nodes.size() * sizeof(NodeDefinition);
  for (const Ray& ray : group.rays) {
    sum += ray.rounds.size() * sizeof(Round) + ray.events.size() * sizeof(Event) +
           ray.processed.size() * sizeof(Processed) + ray.bins.size();
  }
  return sum;
}

/// The same for groups with these totals, without their nodes, which are few.
inline std::uint64_t decoded_bytes(const Totals& totals) {
  return (totals.visits() + totals.culls + totals.checkpoints_read) * sizeof(Event) +
         totals.processed * sizeof(Processed) + totals.rounds * sizeof(Round) + totals.checkpoints_written;
}

/// Call before allocating `bytes`. Throws Malformed if less is free. Queries the system once per 8 MiB and thread.
void take_memory(std::uint64_t bytes);

}  // namespace grtx::traces
