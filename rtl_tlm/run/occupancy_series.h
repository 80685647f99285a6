// SPDX-License-Identifier: Apache-2.0
// Occupancy over time: a coarse series of a run, whatever its length. Boundaries lie at multiples of an interval that
// doubles whenever there are kMost of them, so a run has between kMost / 2 and kMost points.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "grtx/rtl_tlm/gpu/gpu.h"
#include "grtx/rtl_tlm/gpu/memory_system.h"

namespace grtx::sim {

class OccupancySeries {
 public:
  static constexpr std::size_t kMost = 64;

  /// Both must outlive the series.
  OccupancySeries(const Gpu& gpu, const MemorySystem& memory) : gpu_(gpu), memory_(memory) {}

  /// The cycle of the next point: step the kernel there, then call sample().
  Cycle next() const { return next_; }
  void sample();
  /// The points up to `end`, the last cycle of the run: {"end_of_interval": [cycles], name: {unit, description,
  /// values}}.
  nlohmann::ordered_json json(Cycle end) const;

 private:
  /// Sums since the start of the run.
  struct Point {
    Cycle cycle = 0;
    std::uint64_t rt_warps = 0;       ///< warps in warp buffers x cycles
    std::uint64_t rt_selections = 0;  ///< cycles in which RT units scheduled a warp
    std::uint64_t dram_bytes = 0;
    std::uint64_t resident = 0;  ///< warps in the SMs at this cycle; not a sum
  };
  Point point(Cycle cycle) const;

  const Gpu& gpu_;
  const MemorySystem& memory_;
  Cycle interval_ = 256;
  Cycle next_ = 256;
  std::vector<Point> points_;
};

}  // namespace grtx::sim
