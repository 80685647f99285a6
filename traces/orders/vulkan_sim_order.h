// SPDX-License-Identifier: Apache-2.0
// Child order vulkan_sim (ubc-aamodt-group/vulkan-sim, src/cuda-sim/vulkan_ray_tracing.cc; both levels): the first hit
// internal child in slot order is visited at once; all others, and all leaves, are pushed in slot order. The stack is
// LIFO, so the highest pushed slot is visited first. Nothing is sorted by distance.
#pragma once

#include <bit>

#include "grtx/traces/modes.h"

namespace grtx::traces {

struct VulkanSimOrder {
  static constexpr ChildOrder kName = ChildOrder::vulkan_sim;
  static constexpr bool kBySlots = true;
  static constexpr bool kFollows = true;
  static constexpr unsigned place(unsigned slot, unsigned hit, unsigned /*rank*/) {
    return static_cast<unsigned>(std::popcount(hit >> slot >> 1));
  }
  static constexpr unsigned followed(unsigned pushed, unsigned internal) {
    const unsigned candidates = pushed & internal;
    return candidates & (0U - candidates);  // the lowest slot
  }
};

}  // namespace grtx::traces
