// SPDX-License-Identifier: Apache-2.0
#include "grtx/traces/source_assignment.h"

#include <algorithm>

namespace grtx::traces {
namespace {

bool is_read(const Event& event) {
  return event.kind() == EventKind::replay_take || event.kind() == EventKind::replay_forward;
}

}  // namespace

const std::vector<std::uint32_t>& SourceAssignment::assign(std::span<const std::uint32_t> addresses,
                                                           const std::vector<NodeReference>& source,
                                                           std::span<const Event> events,
                                                           const InstanceLevels& levels) {
  by_address_.resize(source.size());
  for (std::uint32_t i = 0; i < source.size(); ++i) by_address_[i] = {addresses[i], i};
  std::sort(by_address_.begin(), by_address_.end());
  claimed_.assign(source.size(), false);
  positions_.clear();
  for (std::size_t i = 0; i < events.size(); ++i) {
    if (!is_read(events[i])) continue;
    std::uint32_t position = kNone;
    if (events[i].kind() == EventKind::replay_take) {
      InstancePath path;
      std::size_t next = i + 1;
      if (levels.is_object(events[i].node) && next < events.size()) path.scene = events[next++].node;
      if (levels.is_blas(events[i].node) && next < events.size()) path.instance = events[next].node;
      position = claim(source, events[i].node, &path);
    }
    positions_.push_back(position);
  }
  std::size_t read = 0;
  for (const Event& event : events) {
    if (!is_read(event)) continue;
    if (event.kind() == EventKind::replay_forward) positions_[read] = claim(source, event.node, nullptr);
    ++read;
  }
  return positions_;
}

std::uint32_t SourceAssignment::claim(const std::vector<NodeReference>& source, std::uint32_t address,
                                      const InstancePath* path) {
  auto at = std::lower_bound(by_address_.begin(), by_address_.end(), std::pair{address, std::uint32_t{0}});
  for (; at != by_address_.end() && at->first == address; ++at) {
    const std::uint32_t position = at->second;
    if (claimed_[position] || (path != nullptr && source[position].path != *path)) continue;
    claimed_[position] = true;
    return position;
  }
  return kNone;
}

}  // namespace grtx::traces
