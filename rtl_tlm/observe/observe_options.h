// SPDX-License-Identifier: Apache-2.0
// Options of the files that a run writes for viewers: which cycles, which signals, where to.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/base/declare/named_enum.h"
#include "grtx/base/strong.h"
#include "grtx/modules/kernel/clock_domain.h"

namespace grtx::sim {

/// A range of core cycles, both ends included.
struct CycleWindow {
  Cycle first = 0;
  Cycle last = modules::kNever;
  bool contains(Cycle cycle) const { return cycle >= first && cycle <= last; }
};

enum class WaveLevel : std::uint8_t {
  units,   ///< state, occupancy and queue levels of each unit
  signals  ///< also each warp, each shader slot, each link
};
constexpr auto enum_names(WaveLevel) { return names_in_order<WaveLevel>({"units", "signals"}); }

struct WaveformOptions {
  std::string path;         ///< empty: no waveform
  std::string scope = "*";  ///< only signals whose name or enclosing scope matches (Wires)
  CycleWindow window;
  WaveLevel level = WaveLevel::signals;
};

struct TimelineOptions {
  std::string path;  ///< empty: no timeline
  CycleWindow window;
  Cycle counter_cycles = 256;  ///< cycles between two values of a counter; rates are means over them
};

}  // namespace grtx::sim
