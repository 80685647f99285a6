// SPDX-License-Identifier: Apache-2.0
// Keys of the any-hit collector, and the counters of it and of the parts that take its place.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/rt_unit/part/part_info.h"

namespace grtx::modules {

struct AnyHitCollectorConfig {
  std::uint64_t timeout = 64;
  void parameters(ParameterList& list) {
    list.add("timeout", timeout, {0, 1e6}, "cycles",
             "an any-hit batch is sent this long after its first lane began to wait", kOurs);
  }
};
/// The part's row in the table of all parts.
PartInfo part_info(const AnyHitCollectorConfig& config);

/// Counters of an any-hit unit; 0 if shaders handle the hits.
struct AnyHitUnitCounters {
  std::uint64_t hits = 0;         ///< timed or not
  std::uint64_t entered = 0;      ///< of these, hits that entered a heap
  std::uint64_t busy_cycles = 0;  ///< heap logic x cycles
  std::uint64_t wait_cycles = 0;  ///< cycles that hits waited for their heap logic
  std::uint64_t answers = 0;      ///< hits answered
  std::uint64_t bounded = 0;      ///< with opacity_bound: hits whose opacity was added
  std::uint64_t hidden = 0;       ///< and entries that left heaps because of it
};

struct AnyHitCounters {
  std::uint64_t batches = 0;
  std::uint64_t lanes = 0;        ///< lanes in all batches
  std::uint64_t timeouts = 0;     ///< batches sent by timeout, while some active lane had no hit yet
  std::uint64_t wait_cycles = 0;  ///< cycles from the first waiting lane to the invocation, summed over batches
  AnyHitUnitCounters unit;
  static const CounterTable<AnyHitCounters>& table();
  void add(const AnyHitCounters& other) { table().add(*this, other); }
  void describe(StatisticList& list, const std::string& prefix) const { table().describe(*this, list, prefix); }
};

}  // namespace grtx::modules
