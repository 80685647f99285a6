// SPDX-License-Identifier: Apache-2.0
// Configuration and counters of the work distributor.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "grtx/base/strong.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/simt/decide/launch_order.h"

namespace grtx::modules {

/// Counters of a work distributor.
struct DistributorCounters {
  std::uint64_t groups = 0;
  std::uint64_t most_on_one_sm = 0;
  std::uint64_t fewest_on_one_sm = 0;
  Cycle tail_cycles = 0;  ///< from the launch of the last warp to the end
  std::vector<LaunchSpan> launches;
};

struct WorkDistributorConfig {
  unsigned sms = 8;
  unsigned resident_warps = 32;              ///< warp slots of an SM
  std::string distribution = "round_robin";  ///< name of a WorkDistribution
};

/// Appends the counters as prefix + ".name".
void describe(const DistributorCounters& counters, StatisticList& list, const std::string& prefix);

}  // namespace grtx::modules
