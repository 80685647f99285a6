#include "grtx/modules/rt_unit/checkpoint_layout.h"

#include "grtx/base/error.h"

namespace grtx::modules {

CheckpointLayout::Lane CheckpointLayout::begin(const MemoryMap& map, std::uint64_t ray_slot, std::uint32_t round,
                                               std::uint32_t source_entries) const {
  Lane lane;
  lane.destination = map.checkpoint_entry(ray_slot, round & 1, 0);
  lane.source = map.checkpoint_entry(ray_slot, (round & 1) ^ 1, 0);
  lane.source_entries = source_entries;
  return lane;
}

void CheckpointLayout::refuse(const char* does) {
  throw Error("trace", "checkpoint buffer",
              std::string("a ray ") + does + " more entries than the header's checkpoint_capacity");
}

}  // namespace grtx::modules
