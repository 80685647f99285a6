#include "grtx/modules/rt_unit/rt_unit_counters.h"

namespace grtx::modules {

void RtUnitCounters::add(const RtUnitCounters& other) {
  units += other.units;
  warp_buffer.add(other.warp_buffer);
  scheduler.add(other.scheduler);
  memory.add(other.memory);
  ray_box.add(other.ray_box);
  ray_triangle.add(other.ray_triangle);
  ray_sphere.add(other.ray_sphere);
  ray_transform.add(other.ray_transform);
  any_hit.add(other.any_hit);
  checkpoint.add(other.checkpoint);
  prefetch.add(other.prefetch);
  stack.add(other.stack);
}

void RtUnitCounters::describe(StatisticList& list, const std::string& prefix, Cycle cycles) const {
  memory.describe(list, prefix);
  scheduler.describe(list, prefix);
  warp_buffer.describe(list, prefix);
  const double unit_cycles = static_cast<double>(units) * static_cast<double>(cycles);
  list.add(prefix + ".occupancy",
           unit_cycles > 0.0 ? static_cast<double>(warp_buffer.occupancy_integral) / unit_cycles : 0.0, "warps",
           "mean warps in the warp buffer of an RT unit");
  ray_box.describe(list, prefix + ".ray_box");
  ray_triangle.describe(list, prefix + ".ray_triangle");
  ray_sphere.describe(list, prefix + ".ray_sphere");
  ray_transform.describe(list, prefix + ".ray_transform");
  any_hit.describe(list, prefix + ".any_hit");
  checkpoint.describe(list, prefix + ".checkpoint");
  prefetch.describe(list, prefix + ".prefetch");
  stack.describe(list, prefix + ".stack");
}

IntersectionUnit::Counters* RtUnitCounters::of_unit(std::string_view name) {
  if (name == "ray_box") return &ray_box;
  if (name == "ray_triangle") return &ray_triangle;
  if (name == "ray_sphere") return &ray_sphere;
  if (name == "ray_transform") return &ray_transform;
  return nullptr;
}

}  // namespace grtx::modules
