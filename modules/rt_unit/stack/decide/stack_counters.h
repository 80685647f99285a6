// SPDX-License-Identifier: Apache-2.0
// Counters of the stack unit. Its keys are those of the warp buffer.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/rt_unit/part/part_info.h"

namespace grtx::modules {

struct StackCounters {
  std::uint64_t spills = 0;        ///< sectors written
  std::uint64_t fills = 0;         ///< sectors read
  std::uint64_t acknowledged = 0;  ///< write responses
  std::uint64_t returned = 0;      ///< read responses
  std::uint64_t max_spilled = 0;   ///< most spilled entries of a lane
  std::uint64_t moved_out = 0;     ///< sectors spilled, timed or functional
  std::uint64_t moved_in = 0;      ///< sectors filled, timed or functional
  static const CounterTable<StackCounters>& table();
  void add(const StackCounters& other) { table().add(*this, other); }
  void describe(StatisticList& list, const std::string& prefix) const { table().describe(*this, list, prefix); }
};
/// The part's row in the table of all parts.
PartInfo stack_unit_info();

}  // namespace grtx::modules
