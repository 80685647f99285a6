// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/rt_unit_table.h"

#include <string>
#include <utility>

#include "grtx/modules/rt_unit/stack/decide/stack_counters.h"

namespace grtx::modules {
namespace {

using Added = std::vector<std::function<PartInfo(const OwnKeys&)>>;

Added& added() {
  static Added parts;
  return parts;
}

/// The part; if `idle`, these keys of it have no effect.
PartInfo with_idle(PartInfo part, bool idle, const std::string& keys, const std::string& because) {
  if (idle) part.idle_keys.push_back({keys, because});
  return part;
}

}  // namespace

// In the order of the data flow: who moved first (grtx regress) is found by it.
std::vector<PartInfo> part_table(const RtUnitConfig& c, const OwnKeys& own) {
  const std::string traversal = "rt.traversal = " + std::string(name_of(c.traversal));
  const std::string heaps = std::string("rt.any_hit_unit.enabled = ") + (c.any_hit_unit.enabled ? "true" : "false");
  std::vector<PartInfo> parts = {
      part_info(c.scheduler),
      part_info(c.warp_buffer),
      with_idle(part_info(c.warp_stack, c.walks(), c.warp_buffer.ray_banks), !c.walks(), "rt.warp_stack.", traversal),
      with_idle(stack_unit_info(), c.walks(), "rt.warp_buffer.stack_entries", traversal),
      part_info(c.memory, c.walks()),
      ray_box_info(c.ray_box),
      ray_triangle_info(c.ray_triangle),
      ray_sphere_info(c.ray_sphere),
      with_idle(ray_gaussian_info(c.ray_gaussian), !c.gaussian_unit, "rt.gaussian.", "rt.gaussian.enabled = false"),
      ray_transform_info(c.ray_transform),
      with_idle(part_info(c.any_hit_unit), !c.any_hit_unit.enabled, "rt.any_hit_unit.", heaps),
      with_idle(part_info(c.any_hit), c.any_hit_unit.enabled, "rt.any_hit.timeout", heaps),
      part_info(c.checkpoint),
      with_idle(part_info(c.prefetcher), c.walks(), "rt.prefetch.", traversal),
  };
  for (const auto& part : added()) parts.push_back(part(own));
  return parts;
}

void add_part(std::function<PartInfo(const OwnKeys& own)> part) { added().push_back(std::move(part)); }

}  // namespace grtx::modules
