// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/estimate/windows/window_plan.h"

#include <algorithm>

#include "grtx/base/split_mix.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {

std::uint64_t window_slots(const GpuConfig& config) { return std::uint64_t{config.sms} * config.resident_warps; }

std::vector<Window> plan_windows(std::uint64_t groups, std::uint64_t slots, double share, std::uint64_t seed) {
  const std::uint64_t length = settling_groups(slots) + measured_groups(slots), start = starting_groups(slots);
  const auto asked = static_cast<std::uint64_t>(share * static_cast<double>(groups) / static_cast<double>(length));
  const std::uint64_t count = std::max(kFewestWindows, asked);
  if (static_cast<double>(count * length) > kMostOfTrace * static_cast<double>(groups)) return {};
  SplitMix64 random(seed);
  std::vector<Window> windows;
  for (std::uint64_t i = 0; i < count; ++i) {
    Window window;
    window.stratum_first = start + (groups - start) * i / count;
    window.stratum_end = start + (groups - start) * (i + 1) / count;
    const std::uint64_t room = window.stratum_end - window.stratum_first - length;
    if (i == 0) {
      window.measured = start;
    } else {
      window.first = window.stratum_first + (i + 1 == count ? room : random.below(room + 1));
      window.measured = window.first + settling_groups(slots);
    }
    window.end = window.measured + measured_groups(slots);
    windows.push_back(window);
  }
  return windows;
}

std::vector<std::uint64_t> groups_of(const std::vector<Window>& windows) {
  std::vector<std::uint64_t> groups;
  for (const Window& window : windows) {
    for (std::uint64_t group = window.first; group < window.end; ++group) groups.push_back(group);
  }
  return groups;
}

}  // namespace grtx::sim
