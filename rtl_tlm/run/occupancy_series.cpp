// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/run/occupancy_series.h"

#include <algorithm>

namespace grtx::sim {

OccupancySeries::Point OccupancySeries::point(Cycle cycle) const {
  Point p;
  p.cycle = cycle;
  for (const auto& sm : gpu_.sms()) {
    for (const auto& rt : sm->rt_units()) {
      p.rt_warps += rt->warp_cycles_until(cycle);
      p.rt_selections += rt->selections();
    }
  }
  p.dram_bytes = memory_.total().bytes;
  p.resident = gpu_.distributor().running();
  return p;
}

void OccupancySeries::sample() {
  points_.push_back(point(next_));
  if (points_.size() == kMost) {
    for (std::size_t i = 0; i < kMost / 2; ++i) points_[i] = points_[2 * i + 1];
    points_.resize(kMost / 2);
    interval_ *= 2;
  }
  next_ += interval_;
}

nlohmann::ordered_json OccupancySeries::json(Cycle end) const {
  using nlohmann::ordered_json;
  std::vector<Point> points = points_;
  while (!points.empty() && points.back().cycle >= end) points.pop_back();
  if (end > 0) points.push_back(point(end));
  ordered_json cycles = ordered_json::array(), occupancy = cycles, issue = cycles, resident = cycles, bytes = cycles;
  std::size_t units = 0;
  for (const auto& sm : gpu_.sms()) units += sm->rt_units().size();
  Point before;
  for (const Point& p : points) {
    const double length = static_cast<double>(p.cycle - before.cycle);
    const double unit_cycles = length * static_cast<double>(units);
    cycles.push_back(p.cycle);
    occupancy.push_back(static_cast<double>(p.rt_warps - before.rt_warps) / unit_cycles);
    issue.push_back(static_cast<double>(p.rt_selections - before.rt_selections) / unit_cycles);
    resident.push_back(p.resident);
    bytes.push_back(static_cast<double>(p.dram_bytes - before.dram_bytes) / length);
    before = p;
  }
  const auto series = [](const char* unit, const char* description, ordered_json values) {
    return ordered_json{{"unit", unit}, {"description", description}, {"values", std::move(values)}};
  };
  ordered_json json;
  json["end_of_interval"] = series("cycles", "where each interval ends; the first begins at 0", std::move(cycles));
  json["rt.occupancy"] = series("warps", "mean warps in the warp buffer of an RT unit", std::move(occupancy));
  json["rt.selections"] = series("ratio", "cycles in which an RT unit scheduled a warp / cycles", std::move(issue));
  json["resident_warps"] = series("warps", "warps in all SMs at the end of the interval", std::move(resident));
  json["dram.bytes_per_cycle"] = series("B/cycle", "bytes to and from DRAM a core cycle", std::move(bytes));
  return json;
}

}  // namespace grtx::sim
