// The pipelines of one kind of intersection unit in fast mode.
#pragma once

#include <algorithm>
#include <vector>

#include "grtx/modules/rt_unit/intersection_unit.h"
#include "grtx/rtl_tlm/estimate/fast/slot_calendar.h"

namespace grtx::sim::fast {

class IntersectionPipelines {
 public:
  explicit IntersectionPipelines(const modules::IntersectionUnit::Config& config)
      : config_(config), places_(config.count), free_(config.interval == 1 ? 0 : config.count) {}

  /// When the result of tests is known on data that is there from cycle `ready` on.
  Cycle test(Cycle ready, unsigned tests) {
    if (!free_.empty()) return test_in_turn(ready, tests);
    Cycle start = places_.reserve(ready + 1);
    counters_.queue_cycles += start - (ready + 1);
    ++counters_.operations;
    counters_.tests += tests;
    counters_.busy_cycles += tests;
    for (unsigned i = 1; i < tests; ++i) start = places_.reserve(start + 1);
    return start + config_.latency;
  }
  void advance(Cycle now) { places_.advance(now); }
  const modules::IntersectionUnit::Counters& counters() const { return counters_; }

 private:
  /// A test that holds its pipeline for several cycles takes the one that is free first.
  Cycle test_in_turn(Cycle ready, unsigned tests) {
    Cycle& free = *std::min_element(free_.begin(), free_.end());
    const Cycle start = std::max(ready + 1, free);
    free = start + Cycle{tests} * config_.interval;
    counters_.queue_cycles += start - (ready + 1);
    ++counters_.operations;
    counters_.tests += tests;
    counters_.busy_cycles += free - start;
    return free - config_.interval + config_.latency;
  }

  modules::IntersectionUnit::Config config_;
  SlotCalendar places_;      ///< of pipelines that take a test a cycle
  std::vector<Cycle> free_;  ///< else when each of them is
  modules::IntersectionUnit::Counters counters_;
};

}  // namespace grtx::sim::fast
