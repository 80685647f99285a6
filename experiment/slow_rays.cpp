// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/slow_rays.h"

#include <algorithm>
#include <functional>
#include <utility>

namespace grtx::experiment {

std::uint64_t visits_of(const traces::Ray& ray) {
  return static_cast<std::uint64_t>(std::ranges::count_if(
      ray.events, [](const traces::Event& event) { return event.kind() <= traces::EventKind::visit_leaf; }));
}

namespace {

/// Whether a ray has a hit: one that sees the sky visits the root alone, and would be the median of many views.
bool meets_something(const traces::Ray& ray) {
  return std::ranges::any_of(ray.rounds, [](const traces::Round& round) { return round.k_count > 0; });
}

std::uint64_t median_of(std::vector<std::uint64_t> all) {
  if (all.empty()) return 0;
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::ranges::nth_element(all, middle);
  return *middle;
}

}  // namespace

SlowRays slowest_rays(const traces::Reader& reader, std::size_t count) {
  SlowRays slow;
  std::vector<std::uint64_t> all;
  traces::RayGroup group;
  const std::uint32_t width = reader.header().width;
  const auto keep = [&](std::size_t most) {
    std::ranges::stable_sort(slow.rays, std::greater(), &SlowRay::visits);
    if (slow.rays.size() > most) slow.rays.resize(most);
  };
  for (std::uint64_t warp = 0; warp < reader.group_count(); ++warp) {
    reader.read(warp, group);
    for (const traces::Ray& ray : group.rays) {
      if (ray.rounds.empty()) continue;
      const std::uint64_t visits = visits_of(ray);
      if (meets_something(ray)) all.push_back(visits);
      slow.rays.push_back(
          {ray.pixel % width, ray.pixel / width, group.frame, group.kind, warp, visits, ray.rounds.size()});
    }
    if (slow.rays.size() > 2 * count + 4096) keep(count);
  }
  keep(count);
  slow.median = median_of(std::move(all));
  return slow;
}

std::uint64_t median_visits(const traces::Reader& reader, std::uint32_t frame) {
  constexpr std::uint64_t kMostWarps = 2048;
  const std::vector<std::uint64_t>& frames = reader.header().frame_groups;
  std::uint64_t begin = 0;
  for (std::uint32_t i = 0; i < frame; ++i) begin += frames.at(i);
  const std::uint64_t end = frames.empty() ? reader.group_count() : begin + frames.at(frame);
  const std::uint64_t step = std::max<std::uint64_t>(1, (end - begin) / kMostWarps);
  std::vector<std::uint64_t> all;
  traces::RayGroup group;
  for (std::uint64_t warp = begin; warp < end; warp += step) {
    reader.read(warp, group);
    for (const traces::Ray& ray : group.rays) {
      if (meets_something(ray)) all.push_back(visits_of(ray));
    }
  }
  return median_of(std::move(all));
}

}  // namespace grtx::experiment
