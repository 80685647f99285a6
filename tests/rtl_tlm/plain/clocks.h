// SPDX-License-Identifier: Apache-2.0
// Two clocks as grids of time from 0: docs/model/tlm.md, "Time".
#pragma once

#include <cmath>
#include <cstdint>

#include "rtl_tlm/plain/channel.h"

namespace grtx::sim::plain {

using Femtoseconds = std::uint64_t;

struct Clock {
  Femtoseconds period;
  explicit Clock(double mhz) : period(static_cast<Femtoseconds>(std::llround(1e9 / mhz))) {}
  Femtoseconds edge(Cycle cycle) const { return cycle * period; }
  /// The first cycle whose edge lies after the time: there it sees what took effect then.
  Cycle first_after(Femtoseconds time) const { return time / period + 1; }
};

}  // namespace grtx::sim::plain
