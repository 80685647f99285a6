// SPDX-License-Identifier: Apache-2.0
// Counters of one RT unit and of its parts, or their sum over several.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/rt_unit/prefetcher/decide/prefetch_config.h"
#include "grtx/modules/rt_unit/warp_buffer/decide/warp_wait.h"

namespace grtx::modules {

/// Counters of a warp buffer.
struct WarpBufferCounters {
  std::uint64_t calls = 0;               ///< traceRay calls accepted
  std::uint64_t occupancy_integral = 0;  ///< warps x cycles
  std::uint64_t max_stack_depth = 0;
  std::array<std::uint64_t, kWarpWaits> warp_cycles{};  ///< [WarpWait] warps x cycles
  Distribution warp_latency;                            ///< cycles from acceptance to retirement
  static const CounterTable<WarpBufferCounters>& table();
  void add(const WarpBufferCounters& other) { table().add(*this, other); }
  void describe(StatisticList& list, const std::string& prefix) const { table().describe(*this, list, prefix); }
};

/// Counters of warps that walk together; 0 if each lane has a stack.
struct WarpWalkCounters {
  std::uint64_t entries = 0;       ///< started, or dropped
  std::uint64_t dropped = 0;       ///< beyond t_max of all their lanes
  std::uint64_t in_vain = 0;       ///< tests of lanes for which the node is beyond t_max
  std::uint64_t under_way = 0;     ///< entries of the warp under way at a start, itself included, summed over starts
  std::uint64_t most_waiting = 0;  ///< most entries of a warp that waited, in memory or not
};

struct RtSchedulerCounters {
  std::uint64_t selections = 0, lanes_handled = 0, lanes_active = 0;
  std::array<std::uint64_t, kStalls> stall{};
  // Trace events executed.
  std::uint64_t visits_internal = 0, visits_instance = 0, visits_leaf = 0, culls = 0;
  std::uint64_t replay_takes = 0, replay_forwards = 0, any_hit_calls = 0, intersection_calls = 0;
  WarpWalkCounters walk;
  std::uint64_t events() const {
    return visits_internal + visits_instance + visits_leaf + culls + replay_takes + replay_forwards;
  }
  double simt_efficiency() const {
    return lanes_active == 0 ? 0.0 : static_cast<double>(lanes_handled) / static_cast<double>(lanes_active);
  }
  static const CounterTable<RtSchedulerCounters>& table();
  void add(const RtSchedulerCounters& other) { table().add(*this, other); }
  void describe(StatisticList& list, const std::string& prefix) const { table().describe(*this, list, prefix); }
};

struct MemorySchedulerCounters {
  std::array<std::uint64_t, kRegionCount> visits{};   ///< lane visits
  std::array<std::uint64_t, kRegionCount> fetches{};  ///< after merging
  std::array<std::uint64_t, kRegionCount> sectors{};  ///< requests sent
  std::uint64_t shader_batches = 0;                   ///< by_shader: messages to the SIMT core
  std::uint64_t shader_sectors = 0;                   ///< by_shader: sectors in these messages, equals sum of `sectors`
  Distribution fetch_latency;                         ///< cycles from the first lane's visit to the last sector
  std::uint64_t node_visits() const;
  std::uint64_t node_fetches() const;
  std::uint64_t node_sectors() const;
  static const CounterTable<MemorySchedulerCounters>& table();
  void add(const MemorySchedulerCounters& other) { table().add(*this, other); }
  void describe(StatisticList& list, const std::string& prefix) const { table().describe(*this, list, prefix); }
};

/// Counters of an any-hit unit; 0 if shaders handle the hits.
struct AnyHitUnitCounters {
  std::uint64_t hits = 0;         ///< timed or not
  std::uint64_t entered = 0;      ///< of these, hits that entered a heap
  std::uint64_t busy_cycles = 0;  ///< heap logic x cycles
  std::uint64_t wait_cycles = 0;  ///< cycles that hits waited for their heap logic
  std::uint64_t answers = 0;      ///< hits answered
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

struct CheckpointCounters {
  std::uint64_t entries_written = 0, entries_read = 0, sectors_written = 0, sectors_read = 0;
  std::uint64_t acknowledged = 0, returned = 0;  ///< responses to writes and reads
  std::uint64_t straddling_written = 0, straddling_read = 0;
  std::uint64_t max_entries = 0, blocked_cycles = 0;
  static const CounterTable<CheckpointCounters>& table();
  void add(const CheckpointCounters& other) { table().add(*this, other); }
  void describe(StatisticList& list, const std::string& prefix) const { table().describe(*this, list, prefix); }
};

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

struct IntersectionCounters {
  std::uint64_t operations = 0;    ///< lane operations started
  std::uint64_t tests = 0;         ///< tests of these operations (an operation may have several, e.g. one per child)
  std::uint64_t busy_cycles = 0;   ///< pipeline-cycles in which no further test could start: tests x interval
  std::uint64_t queue_cycles = 0;  ///< cycles that lanes waited in the queue beyond the first
  std::uint64_t queue_max = 0;     ///< longest queue
  static const CounterTable<IntersectionCounters>& table();
  void add(const IntersectionCounters& other) { table().add(*this, other); }
  void describe(StatisticList& list, const std::string& prefix) const { table().describe(*this, list, prefix); }
};

/// Counters of parts that do not exist stay 0.
struct RtUnitCounters {
  std::uint64_t units = 0;  ///< number of RT units summed
  Cycle cycles = 0;         ///< length of the run; set by describe()
  WarpBufferCounters warp_buffer;
  RtSchedulerCounters scheduler;
  MemorySchedulerCounters memory;
  IntersectionCounters ray_box;
  IntersectionCounters ray_triangle;
  IntersectionCounters ray_sphere;
  IntersectionCounters ray_gaussian;
  IntersectionCounters ray_transform;
  AnyHitCounters any_hit;
  CheckpointCounters checkpoint;
  PrefetchCounters prefetch;
  StackCounters stack;
  OwnCounts own;  ///< extra counters of user-supplied parts

  static const CounterTable<RtUnitCounters>& table();
  void add(const RtUnitCounters& other) { table().add(*this, other); }
  /// cycles: length of the run, for the mean occupancy of a warp buffer.
  void describe(StatisticList& list, const std::string& prefix, Cycle cycles) const;
};

}  // namespace grtx::modules
