// SPDX-License-Identifier: Apache-2.0
// Cycles that a data path needs at a process node and clock, from the delays of its chain of operators.
#pragma once

#include <string>
#include <vector>

namespace grtx::explore {

/// Sum over the operators along a critical path (PartPipelines: add, mul, min_max, less) of ceil(delay x factor /
/// (clock period - register overhead)). Delays are those at 45 nm (Yosys, Nangate45, timing-driven). Throws Error if
/// the clock period is not longer than the register overhead.
unsigned cycles_needed(const std::vector<std::string>& critical_path, double delay_factor, double clock_mhz);

}  // namespace grtx::explore
