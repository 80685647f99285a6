// The node fetches of a warp in fast mode, each by the lane that asked first: until it has arrived, that lane asks for
// nothing else.
#pragma once

#include <array>
#include <cstdint>

#include "grtx/modules/kernel/equal_keys.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/rt_unit/decide/node_visit.h"
#include "grtx/rtl_tlm/estimate/fast/near_cycle.h"

namespace grtx::sim::fast {

struct NodeFetches {
  std::array<std::uint32_t, modules::kMaxLanes> key;
  std::array<NearCycle, modules::kMaxLanes> asked;
  std::array<NearCycle, modules::kMaxLanes> ready;      ///< the sectors that have been asked for have been seen
  std::array<std::uint32_t, modules::kMaxLanes> lanes;  ///< that wait for it to be asked for; 0: it has been

  void clear(Cycle now) {
    key.fill(~std::uint32_t{0});
    asked.fill(NearCycle(now));
    ready.fill(NearCycle(now));
    lanes.fill(0);
  }
  static std::uint32_t key_of(const modules::NodeVisit& node) {
    return static_cast<std::uint32_t>(node.address / traces::kNodeUnit) << 1 | (node.header ? 1u : 0u);
  }
  /// Lanes whose fetch was or is for that node.
  std::uint32_t of_node(std::uint32_t wanted) const {
    static_assert(modules::kMaxLanes == 32);
    return modules::equal_keys(key.data(), wanted) | modules::equal_keys(key.data() + 16, wanted) << 16;
  }
};

}  // namespace grtx::sim::fast
