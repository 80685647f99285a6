// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/rt_unit_counters.h"

namespace grtx::modules {

const CounterTable<RtUnitCounters>& RtUnitCounters::table() {
  using C = RtUnitCounters;
  static const CounterTable<C> table =
      CounterTable<C>()
          .sum(&C::units)
          .part(&C::memory, "")
          .part(&C::scheduler, "")
          .part(&C::warp_buffer, "")
          .own(&C::cycles, [](Cycle&, Cycle) {})
          .mean({"occupancy_integral", [](const C& c) { return c.warp_buffer.occupancy_integral; }},
                {"", [](const C& c) { return c.units * c.cycles; }}, "occupancy", "warps",
                "mean warps in the warp buffer of an RT unit")
          .part(&C::ray_box, ".ray_box")
          .part(&C::ray_triangle, ".ray_triangle")
          .part(&C::ray_sphere, ".ray_sphere")
          .part(&C::ray_transform, ".ray_transform")
          .part(&C::any_hit, ".any_hit")
          .part(&C::checkpoint, ".checkpoint")
          .part(&C::prefetch, ".prefetch")
          .part(&C::stack, ".stack")
          .own_counts(&C::own)
          .when([](const C& c) { return c.ray_gaussian.operations != 0; })
          .part(&C::ray_gaussian, ".ray_gaussian");
  return table;
}

void RtUnitCounters::describe(StatisticList& list, const std::string& prefix, Cycle run) const {
  RtUnitCounters c = *this;
  c.cycles = run;
  table().describe(c, list, prefix);
}

}  // namespace grtx::modules
