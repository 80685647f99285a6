// SPDX-License-Identifier: Apache-2.0
// Least cycles of a traceRay call whose lanes share one stack (rt.traversal = warp): a node waits for its parent, at
// most `ahead` nodes are under way, and each heap takes its hits one after the other.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "grtx/base/strong.h"
#include "grtx/modules/rt_unit/decide/node_traffic.h"
#include "grtx/modules/rt_unit/rt_unit_config.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::modules {
struct WarpStackEntry;  // warp_stack.h
}

namespace grtx::sim {

struct WalkCall {
  Cycle warp = 0;            ///< until the last lane is done
  std::vector<Cycle> lanes;  ///< [lane] until it is done
};

class WalkChain {
 public:
  /// fetch: least cycles from the start of an entry to the answer to its node's last request. shader: least cycles of a
  /// hit's shader, if no any-hit unit takes the hit.
  WalkChain(const modules::RtUnitConfig& config, const traces::Header& header, Cycle fetch, Cycle shader);

  /// first_event: [lane] of this round. A trace that a warp cannot walk takes 0 cycles: the scheduler refuses it.
  WalkCall measure(const traces::RayGroup& group, std::size_t round, std::span<const std::size_t> first_event) const;

 private:
  struct Stage {
    Cycle latency = 0;  ///< of one lane, from the node's arrival
    std::uint64_t count = 1, interval = 0;
    /// Until the last of `lanes` that come together has its result.
    Cycle last(unsigned lanes) const { return latency + (lanes - 1) / count * interval; }
    /// Least time in which so many tests start.
    Cycle busy(std::uint64_t tests) const { return tests == 0 ? 0 : (tests - 1) / count * interval; }
  };
  /// Cycles of a node's visit, counted from the start of the call.
  struct NodeTimes {
    unsigned sectors = 0;
    Cycle first_result = 0;  ///< of one lane
    Cycle done = 0;          ///< result of the last lane
  };
  /// Work of a call that units share: each takes its least time for it.
  struct UnitLoad {
    std::uint64_t under_way = 0;  ///< cycles of all visits but the root's, summed
    std::uint64_t sectors = 0, box_tests = 0, leaf_tests = 0;
    Cycle root_done = 0;
    void add(const NodeTimes& times, Cycle start, std::uint64_t tests, bool internal) {
      sectors += times.sectors;
      (internal ? box_tests : leaf_tests) += tests;
      if (start == 0) {
        root_done = times.done;
      } else {
        under_way += times.done - start;
      }
    }
  };
  class Hits;
  /// Least cycles of a visit of `entry` that starts in cycle `start`.
  NodeTimes node_times(const modules::WarpStackEntry& entry, Cycle start) const;
  /// Least cycles of a call with this load.
  Cycle least_cycles(const UnitLoad& load) const;

  modules::RtUnitConfig config_;
  modules::NodeTraffic traffic_;
  Cycle fetch_, shader_;
  unsigned k_;
  bool boxes_, by_slot_;
  Stage box_, leaf_, transform_;
};

}  // namespace grtx::sim
