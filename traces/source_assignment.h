// SPDX-License-Identifier: Apache-2.0
// Finds which entry of the source checkpoint buffer each read of a replay round refers to, for read order nearest.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "grtx/traces/event.h"
#include "grtx/traces/instance_levels.h"

namespace grtx::traces {

/// Events name a source entry only by its node address, which many entries share in a shared BLAS. A take also names
/// the instances (by the visit_instance events that follow it), a forward does not. So takes are assigned first, each
/// to the first unread entry with its address and instances; forwards then get the first remaining entries with their
/// address. Exchanged instances among forwards do not matter, because a nearest-first buffer has no order.
class SourceAssignment {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;

  /// For each read of a round, in order: position in `source`, or kNone if no unread entry matches. addresses: node
  /// addresses of the source entries.
  const std::vector<std::uint32_t>& assign(std::span<const std::uint32_t> addresses,
                                           const std::vector<NodeReference>& source, std::span<const Event> events,
                                           const InstanceLevels& levels);

 private:
  std::uint32_t claim(const std::vector<NodeReference>& source, std::uint32_t address, const InstancePath* path);

  std::vector<std::pair<std::uint32_t, std::uint32_t>> by_address_;  ///< (address, position), sorted
  std::vector<bool> claimed_;
  std::vector<std::uint32_t> positions_;
};

}  // namespace grtx::traces
