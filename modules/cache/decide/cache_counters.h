// SPDX-License-Identifier: Apache-2.0
// Counters that L1 and L2 share: accesses per memory region.
#pragma once

#include <array>
#include <cstdint>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

struct RegionCounters {
  std::uint64_t reads = 0;         ///< sector reads accepted = hits + hits_on_miss + misses
  std::uint64_t hits = 0;          ///< sector present
  std::uint64_t hits_on_miss = 0;  ///< merged into a pending MSHR
  std::uint64_t misses = 0;        ///< allocated an MSHR
  std::uint64_t writes = 0;        ///< sector writes accepted
  std::uint64_t write_hits = 0;    ///< of these, sector present

  RegionCounters& operator+=(const RegionCounters& other);
};

/// Descriptions of the region counters in the statistics; L1 and L2 word them differently.
struct RegionWords {
  const char* reads;
  const char* hits;
  const char* hits_on_miss;
  const char* misses;
  const char* writes;
};

struct CacheRegions {
  std::array<RegionCounters, kRegionCount> region{};

  RegionCounters all() const;
  RegionCounters nodes() const;        ///< node regions only
  RegionCounters shader_data() const;  ///< Gaussian and SH records, pixels
};

using RegionArray = std::array<RegionCounters, kRegionCount>;
inline void add_regions(RegionArray& total, const RegionArray& more) {
  for (std::size_t i = 0; i < kRegionCount; ++i) total[i] += more[i];
}

/// Appends prefix + ".all", ".node", ".shader_data" and one group per accessed region.
void describe_regions(const CacheRegions& regions, const RegionWords& words, StatisticList& list,
                      const std::string& prefix);

}  // namespace grtx::modules
