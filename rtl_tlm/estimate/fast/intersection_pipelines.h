// The pipelines of one kind of intersection unit in fast mode.
#pragma once

#include <algorithm>
#include <vector>

#include "grtx/modules/rt_unit/intersection_unit.h"
#include "grtx/rtl_tlm/estimate/fast/slot_calendar.h"
#include "grtx/rtl_tlm/estimate/fast/span_calendar.h"

namespace grtx::sim::fast {

class IntersectionPipelines {
 public:
  explicit IntersectionPipelines(const modules::IntersectionUnit::Config& config)
      : config_(config),
        places_(config.count),
        held_(config.interval == 1 ? 0 : config.count, SpanCalendar(config.interval)) {}

  /// When the result of tests is known on data that is there from cycle `ready` on.
  Cycle test(Cycle ready, unsigned tests) {
    if (!held_.empty()) return test_held(ready, tests);
    Cycle start = places_.reserve(ready + 1);
    counters_.queue_cycles += start - (ready + 1);
    ++counters_.operations;
    counters_.tests += tests;
    counters_.busy_cycles += tests;
    for (unsigned i = 1; i < tests; ++i) start = places_.reserve(start + 1);
    return start + config_.latency;
  }
  void advance(Cycle now) {
    places_.advance(now);
    for (SpanCalendar& pipeline : held_) pipeline.advance(now);
  }
  const modules::IntersectionUnit::Counters& counters() const { return counters_; }

 private:
  /// A test that holds its pipeline for several cycles takes the one that can begin first, and so do those behind it.
  Cycle test_held(Cycle ready, unsigned tests) {
    SpanCalendar& pipeline = *std::ranges::min_element(
        held_, {}, [ready](const SpanCalendar& calendar) { return calendar.first_free(ready + 1); });
    Cycle start = pipeline.reserve(ready + 1);
    counters_.queue_cycles += start - (ready + 1);
    ++counters_.operations;
    counters_.tests += tests;
    counters_.busy_cycles += Cycle{tests} * config_.interval;
    for (unsigned i = 1; i < tests; ++i) start = pipeline.reserve(start + config_.interval);
    return start + config_.latency;
  }

  modules::IntersectionUnit::Config config_;
  SlotCalendar places_;             ///< of pipelines that take a test a cycle
  std::vector<SpanCalendar> held_;  ///< else each of them
  modules::IntersectionUnit::Counters counters_;
};

}  // namespace grtx::sim::fast
