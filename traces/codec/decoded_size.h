// What groups take in memory when they are decoded: a small file may stand for a great deal.
#pragma once

#include <cstdint>

#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::traces {

/// Bytes of the arrays' entries.
inline std::uint64_t decoded_bytes(const RayGroup& group) {
  std::uint64_t sum = group.nodes.size() * sizeof(NodeDefinition);
  for (const Ray& ray : group.rays) {
    sum += ray.rounds.size() * sizeof(Round) + ray.events.size() * sizeof(Event) +
           ray.processed.size() * sizeof(Processed) + ray.bins.size();
  }
  return sum;
}

/// The same of groups with these totals, but for the nodes, which are few.
inline std::uint64_t decoded_bytes(const Totals& totals) {
  return (totals.visits() + totals.culls + totals.checkpoints_read) * sizeof(Event) +
         totals.processed * sizeof(Processed) + totals.rounds * sizeof(Round) + totals.checkpoints_written;
}

/// Asked for before it is taken. Throws Malformed when that is more than is free. Asks the system once in every 8 MiB.
void take_memory(std::uint64_t bytes);

}  // namespace grtx::traces
