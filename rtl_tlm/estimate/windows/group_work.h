// SPDX-License-Identifier: Apache-2.0
// The work of a ray group, counted without simulating it, and the sectors that it reads. Windows mode uses the first to
// extrapolate from the groups that it simulates to all others, and gives the second to the caches for groups in
// between.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/rt_unit/decide/node_traffic.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::sim {

struct GroupWork {
  double sectors = 0.0;   ///< node sectors that its rays ask for
  double distinct = 0.0;  ///< sectors of nodes and records, each counted about once
  double steps = 0.0;     ///< of the longest ray of each traceRay call, summed over the calls
  double calls = 0.0;     ///< traceRay calls of its warp
};

class WorkCounter {
 public:
  WorkCounter(const traces::Header& header, const modules::NodeTrafficConfig& traffic) : traffic_(header, traffic) {}
  /// Is called with the address of each sector read, about once each.
  using Read = std::function<void(std::uint64_t address)>;
  /// The group must fit the header (check_group()). read: empty: nobody listens.
  GroupWork count(const traces::RayGroup& group, const modules::MemoryMap& map, const Read& read);

 private:
  void reads(std::uint64_t address, std::uint64_t bytes, const Read& read);

  modules::NodeTraffic traffic_;
  std::array<std::uint64_t, 4096> seen_{};  ///< sector number + 1 of this group, by a hash: what was read lately
  double distinct_ = 0.0;
};

}  // namespace grtx::sim
