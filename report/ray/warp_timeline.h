// SPDX-License-Identifier: Apache-2.0
// Reads one warp from a timeline of `grtx sim`: when its rounds ran, and its activities in them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace grtx::report {

struct WarpSlice {
  std::string name;                  ///< name of the activity; "" for a round
  std::uint32_t round = 0;           ///< number of the round, or of the round that contains the activity
  std::uint64_t begin = 0, end = 0;  ///< core cycles
};

struct WarpTimeline {
  std::vector<WarpSlice> slices;
  std::string config_hash;  ///< configuration of the simulated machine; "" if not recorded
};

/// Reads the slices of a warp, ordered by start. trace_hash: content hash of the trace. group: number of the warp.
/// Throws Error if the file is no timeline, is of another trace, or does not contain the warp.
WarpTimeline read_warp_timeline(const std::string& path, const std::string& trace_hash, std::uint32_t group);

}  // namespace grtx::report
