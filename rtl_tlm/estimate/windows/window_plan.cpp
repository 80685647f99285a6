// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/estimate/windows/window_plan.h"

#include <algorithm>

#include "grtx/base/split_mix.h"

namespace grtx::sim {

std::vector<Window> plan_windows(std::uint64_t groups, std::uint64_t slots, double share, std::uint64_t seed) {
  const std::uint64_t length = settling_groups(slots) + measured_groups(slots);
  const auto count = static_cast<std::uint64_t>(share * static_cast<double>(groups) / static_cast<double>(length));
  if (count < kFewestWindows || groups / count < length) return {};
  SplitMix64 random(seed);
  std::vector<Window> windows;
  for (std::uint64_t i = 0; i < count; ++i) {
    Window window;
    window.stratum_first = groups * i / count;
    window.stratum_end = groups * (i + 1) / count;
    const std::uint64_t stratum = window.stratum_end - window.stratum_first;
    const std::uint64_t more = i == 0 ? std::min(slots - settling_groups(slots), stratum - length) : 0;
    const std::uint64_t room = stratum - length - more;
    window.first = window.stratum_first + (i + 1 == count ? room : random.below(room + 1));
    window.end = window.first + length + more;
    window.measured = window.end - measured_groups(slots);
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
