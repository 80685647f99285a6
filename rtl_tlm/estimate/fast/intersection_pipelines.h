// The pipelines of one kind of intersection unit in fast mode.
#pragma once

#include "grtx/modules/rt_unit/intersection_unit.h"
#include "grtx/rtl_tlm/estimate/fast/slot_calendar.h"

namespace grtx::sim::fast {

class IntersectionPipelines {
 public:
  explicit IntersectionPipelines(const modules::IntersectionUnit::Config& config)
      : config_(config), places_(config.count, config.interval) {}

  /// When the result of tests is known on data that is there from cycle `ready` on.
  Cycle test(Cycle ready, unsigned tests) {
    Cycle start = places_.reserve(ready + 1);
    counters_.queue_cycles += start - (ready + 1);
    ++counters_.operations;
    counters_.tests += tests;
    counters_.busy_cycles += Cycle{tests} * config_.interval;
    for (unsigned i = 1; i < tests; ++i) start = places_.reserve(start + config_.interval);
    return start + config_.latency;
  }
  void advance(Cycle now) { places_.advance(now); }
  const modules::IntersectionUnit::Counters& counters() const { return counters_; }

 private:
  modules::IntersectionUnit::Config config_;
  SlotCalendar places_;
  modules::IntersectionUnit::Counters counters_;
};

}  // namespace grtx::sim::fast
