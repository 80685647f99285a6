// SPDX-License-Identifier: Apache-2.0
// Counters of the DRAM channels.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "grtx/modules/dram/decide/dram_config.h"
#include "grtx/modules/kernel/declare.h"

namespace grtx::modules {

/// Counters of one channel, or their sum over channels.
struct DramChannelCounters {
  std::uint64_t reads = 0, writes = 0, bytes = 0, responses = 0;
  std::uint64_t refused = 0;  ///< malformed transactions, answered with an error status
  std::uint64_t row_hits = 0, row_misses = 0, row_conflicts = 0;
  std::uint64_t activates = 0, precharges = 0, refreshes = 0, bursts = 0, aged = 0;
  std::uint64_t queue_clocks = 0, full_clocks = 0;
  std::uint64_t latency_clocks = 0;  ///< from enqueue to last data, summed over requests

  static const CounterTable<DramChannelCounters>& table();
  DramChannelCounters& operator+=(const DramChannelCounters& other) {
    table().add(*this, other);
    return *this;
  }
};

struct DramCounters {
  DramChannelCounters channel;       ///< summed over channels
  std::uint64_t clocks = 0;          ///< memory clocks since the start
  double bandwidth_utilisation = 0;  ///< bytes / (channels x burst / CCD x clocks)
  Quotient of_peak;                  ///< the same as two whole numbers: bytes x CCD, channels x burst x clocks
};

/// Sums the counters of `channels` and computes the bandwidth utilisation after `clocks` memory clocks.
DramCounters dram_counters(const DramChannelConfig& config, const std::vector<DramChannelCounters>& channels,
                           std::uint64_t clocks);

/// Appends the counters as prefix + ".name"; `channels` holds those of the single channels.
void describe(const DramCounters& counters, const std::vector<DramChannelCounters>& channels, StatisticList& list,
              const std::string& prefix);

}  // namespace grtx::modules
