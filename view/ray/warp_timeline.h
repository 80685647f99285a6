// What a timeline of `grtx sim` says of one warp: when its rounds ran, and what it did in them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace grtx::sim {

struct WarpSlice {
  std::string name;                  ///< of the activity; "": a round
  std::uint32_t round = 0;           ///< an activity's is that of the round around it
  std::uint64_t begin = 0, end = 0;  ///< core cycles
};

struct WarpTimeline {
  std::vector<WarpSlice> slices;
  std::string config_hash;  ///< of the machine that ran; "" when the file does not say it
};

/// Slices in the order of their beginning. Throws Error when the file is no timeline, or of another trace than that
/// with this content hash, or does not show the warp.
WarpTimeline read_warp_timeline(const std::string& path, const std::string& trace_hash, std::uint32_t group);

}  // namespace grtx::sim
