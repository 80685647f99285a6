// SPDX-License-Identifier: Apache-2.0
// Where a design's reads spend their time, by level of the memory: of runs with --latency.
#pragma once

#include <string>
#include <vector>

#include "grtx/report/page/part_bars.h"
#include "grtx/report/page/run_results.h"

namespace grtx::report {

/// Shares of the levels in the time that reads of nodes and leaves take; empty if not recorded.
std::vector<Part> node_read_levels(const DesignResult& design);
/// "DRAM 40 %, L2 30 %, ...": the same from the largest down; "" if not recorded.
std::string node_read_levels_text(const DesignResult& design);
/// A row for each design and kind of read: mean and 95th percentile, whole and by level; "" if no design has them.
std::string read_latency_html(const std::vector<DesignResult>& designs, const std::string& caption);

}  // namespace grtx::report
