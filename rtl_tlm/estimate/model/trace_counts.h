// What a trace asks of the hardware, counted once: how much each lane of each round does, and how soon a warp comes
// back to a node. Kept beside the trace, so that the model of a new configuration decodes nothing.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "grtx/traces/event.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

/// By LRU stack distance (distinct units of nodes that the warp has touched since its last visit): class 0 is distance
/// 0, class c from 2^(c-1) to 2^c - 1, the last one all beyond and first visits.
inline constexpr std::size_t kReuseClasses = 24;

struct LaneCounts {
  std::uint32_t visits = 0;
  std::uint32_t any_hits = 0;
};

/// One traceRay call of a warp.
struct RoundCounts {
  std::vector<LaneCounts> lanes;                     ///< those that visit a node, by ascending visits
  std::array<std::uint32_t, kReuseClasses> reuse{};  ///< visits by class; lanes step together
  std::uint32_t units = 0;                           ///< of 32 bytes that the visited nodes take together
  std::uint32_t written = 0, read = 0;               ///< checkpoint entries
  std::uint32_t processed = 0;                       ///< k-buffer entries looked at
};

struct GroupCounts {
  traces::RayKind kind = traces::RayKind::primary;
  std::vector<RoundCounts> rounds;
};

struct TraceCounts {
  std::string trace;  ///< content hash
  std::vector<GroupCounts> groups;
};

GroupCounts count_group(const traces::RayGroup& group);

/// "TRACE.counts".
std::string counts_path(const std::string& trace_path);
/// Those kept beside the trace, when they are of its content; else the whole trace is counted and they are written
/// there (not where the folder may not be written). Throws Error when the trace is bad or that file is something else.
TraceCounts counts_of(const traces::Reader& reader);

}  // namespace grtx::sim
