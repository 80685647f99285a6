// SPDX-License-Identifier: Apache-2.0
// Keys and counters of a slice of the L2.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "grtx/modules/cache/decide/cache_counters.h"
#include "grtx/modules/cache/decide/cache_geometry.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/address_interleave.h"

namespace grtx::modules {

/// Why the access at the head of the slice's queue, or a fill, had to wait in this cycle.
enum class L2Stall : std::uint8_t { reply_queue, mshr_full, merges_full, dram_queue, fill };
constexpr auto enum_names(L2Stall) {
  return names_in_order<L2Stall>({"reply_queue", "mshr_full", "merges_full", "dram_queue", "fill"});
}

/// Counters of one slice; the GPU sums them over its slices.
struct L2Counters : CacheRegions {
  std::array<std::uint64_t, kCountOf<L2Stall>> stalls{};
  std::uint64_t requests_in = 0;
  std::uint64_t replies_out = 0;
  std::uint64_t dram_reads = 0;                              ///< sectors
  std::uint64_t dram_writes = 0;                             ///< dirty sectors written back
  std::array<std::uint64_t, kRegionCount> dram_reads_of{};   ///< dram_reads per region of the read
  std::array<std::uint64_t, kRegionCount> dram_writes_of{};  ///< dram_writes per region that last dirtied the line
  std::uint64_t evictions = 0;                               ///< lines
  std::uint64_t mshr_cycles = 0;
  Distribution miss_latency;  ///< from MSHR allocation to fill, core cycles
  OwnCounts own;              ///< extra counters of a user-supplied slice

  std::uint64_t accesses() const;
  static const CounterTable<L2Counters>& table();
  L2Counters& operator+=(const L2Counters& other) {
    table().add(*this, other);
    return *this;
  }
  /// Appends them as prefix + ".name".
  void describe(StatisticList& list, const std::string& prefix) const { table().describe(*this, list, prefix); }
};

struct L2SliceConfig {
  unsigned slice = 0;      ///< number of this slice; set by the assembly
  std::uint64_t base = 0;  ///< added to addresses towards the memory; set by the assembly
  bool keep_data = false;  ///< writes carry what the memory holds instead of 0; set by the assembly
  AddressInterleave interleave{};
  CacheGeometry geometry{1024 * 1024, 128, 32, 16};  ///< of one slice
  unsigned latency = 165;  ///< tags are probed after it, so misses pay it too, as with GPGPU-Sim's ROP delay
  unsigned queue = 64;
  unsigned mshr_entries = 192;
  unsigned mshr_merges = 4;
  unsigned reply_queue = 64;
  unsigned dram_queue = 64;
  bool perfect = false;  ///< every access hits; DRAM is never accessed
  /// All but the size, which the GPU declares for all slices together.
  void parameters(ParameterList& list) {
    geometry.shape_parameters(list);
    list.add("latency", latency, {1, kMaxLatency}, "cycles",
             "from request at the slice to the reply of a hit; misses pay it too", kTable1);
    list.add("queue", queue, {1, kMaxEntries}, "requests", "accesses waiting at the tags of a slice", kVulkanSim);
    list.add("mshr_entries", mshr_entries, {1, kMaxEntries}, "sectors", "outstanding of a slice", kVulkanSim);
    list.add("mshr_merges", mshr_merges, {1, kMaxEntries}, "requests",
             "requests of an MSHR of a slice, the first included", kVulkanSim);
    list.add("reply_queue", reply_queue, {1, kMaxEntries}, "replies", "of a slice, waiting for the crossbar",
             kVulkanSim);
    list.add("dram_queue", dram_queue, {1, kMaxEntries}, "requests",
             "reads and write-backs of a slice, waiting for DRAM", kVulkanSim);
    list.add("perfect", perfect, "every access hits (limit study)", kOurs);
    list.rule(
        "bytes", [this] { return geometry.sets() >= 1; },
        "a slice (l2.bytes / l2.slices) must hold at least l2.ways lines of l2.line_bytes");
    list.rule(
        "interleave_bytes", [this] { return geometry.line_bytes <= interleave.bytes; },
        "must not be smaller than l2.line_bytes");
    list.rule(
        "reply_queue", [this] { return reply_queue >= mshr_merges; },
        "must hold the replies of an MSHR (l2.mshr_merges)");
    list.rule(
        "dram_queue", [this] { return dram_queue >= geometry.sectors(); },
        "must hold the write-back of a line (l2.line_bytes / 32)");
  }
};

}  // namespace grtx::modules
