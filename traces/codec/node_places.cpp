// SPDX-License-Identifier: Apache-2.0
#include "grtx/traces/codec/node_places.h"

#include <algorithm>
#include <vector>

#include "grtx/base/error.h"

namespace grtx::traces {

void NodePlaces::add(const RayGroup& group) {
  for (const NodeDefinition& node : group.nodes) {
    Place place;
    place.group = group.index;
    place.child_base = place.child_end = node.child_base;
    for (unsigned slot = 0; slot < node.child_count; ++slot) {
      place.child_end += sizes_.units(node.child_kinds[slot]);
      place.kinds |= static_cast<std::uint32_t>(node.child_kinds[slot]) << (4 * slot);
    }
    add(node.address, place);
  }
}

void NodePlaces::add(const NodePlaces& other) {
  for (const auto& [address, place] : other.places_) add(address, place);
}

// Independent of the threads: keeps the lowest group, and the lowest group that contradicts it.
void NodePlaces::add(std::uint32_t address, const Place& place) {
  const auto [found, added] = places_.emplace(address, place);
  if (added) return;
  Place& known = found->second;
  const std::uint32_t against = std::min(known.contradicted_by, place.contradicted_by);
  if (known.same_node(place)) {
    known.group = std::min(known.group, place.group);
    known.contradicted_by = against;
    return;
  }
  const std::uint32_t later = std::max(known.group, place.group);
  if (place.group < known.group) known = place;
  known.contradicted_by = std::min(against, later);
}

void NodePlaces::check(const std::string& file) const {
  std::vector<std::pair<std::uint32_t, Place>> sorted(places_.begin(), places_.end());
  std::sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  const auto where = [](std::uint32_t group, std::uint32_t address) {
    return "group " + std::to_string(group) + " node " + std::to_string(address);
  };
  for (const auto& [address, place] : sorted) {
    if (place.contradicted_by == kNobody) continue;
    throw Error(file, where(place.contradicted_by, address),
                "has other children than in group " + std::to_string(place.group));
  }
  std::sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) {
    return a.second.child_base != b.second.child_base ? a.second.child_base < b.second.child_base : a.first < b.first;
  });
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    const auto& [address, place] = sorted[i];
    if (place.child_base >= sorted[i - 1].second.child_end) continue;
    throw Error(file, where(place.group, address),
                "its children overlap those of node " + std::to_string(sorted[i - 1].first));
  }
  std::uint64_t wide = 0;
  for (const auto& [address, place] : sorted) {
    for (unsigned slot = 0; slot < kMaxWidth; ++slot) {
      wide += is_wide(static_cast<NodeKind>(place.kinds >> (4 * slot) & 0xF)) ? 1 : 0;
    }
  }
  if (wide > wide_leaves_) throw Error(file, "header", "wide_leaves is below the number of such leaves in the groups");
}

}  // namespace grtx::traces
