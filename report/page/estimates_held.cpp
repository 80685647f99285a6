// SPDX-License-Identifier: Apache-2.0
// Estimates beside cycle mode on one page: whether their intervals hold the cycles that they are estimates of.
#include <algorithm>

#include "grtx/report/page/html.h"
#include "grtx/report/page/sections.h"

namespace grtx::report {
namespace {

/// Whether the results are the same but for the mode: an estimate, and the whole run.
bool is_estimate_of(const DesignResult& estimate, const DesignResult& whole) {
  const std::vector<Fact> facts = estimate.subject.differences(whole.subject, MayDiffer::designs);
  return estimate.name == whole.name && estimate.cycles_interval() && !whole.cycles_interval() &&
         std::ranges::all_of(facts,
                             [](const Fact& fact) { return fact.name == "mode" || fact.name.starts_with("windows."); });
}

void add_row(Table& table, const std::string& what, double estimate, const std::optional<Interval>& interval,
             double whole, std::string (*shown)(double)) {
  if (!interval) return;
  const bool holds = interval->low <= whole && whole <= interval->high;
  table.row({escape(what), shown(estimate), interval_text(interval, shown), shown(whole),
             holds ? "yes" : "<strong>no</strong>"});
}

void add_rows(Table& table, const RunResults& estimated, const RunResults& run) {
  for (const DesignResult& own : estimated.designs) {
    const DesignResult* const whole = run.design(own.name);
    if (whole == nullptr || !is_estimate_of(own, *whole)) continue;
    add_row(table, "cycles of " + own.name, own.value("gpu.cycles"), own.cycles_interval(), whole->value("gpu.cycles"),
            number);
    const DesignResult *const over = estimated.design(estimated.speedup_over), *const its =
                                                                                   run.design(estimated.speedup_over);
    if (over == nullptr || its == nullptr || over == &own) continue;
    add_row(table, "speed-up of " + own.name + " over " + over->name,
            over->value("gpu.cycles") / own.value("gpu.cycles"), estimated.speedup_interval(own),
            its->value("gpu.cycles") / whole->value("gpu.cycles"), times);
  }
}

}  // namespace

std::string estimates_held(const std::vector<ReportRun>& runs) {
  Table table("Estimates beside cycle mode: an interval of 95 % should hold its figure 19 times in 20",
              {{"figure", false}, {"estimate"}, {"interval"}, {"cycle mode"}, {"holds", false}});
  for (const ReportRun& estimated : runs) {
    for (const ReportRun& run : runs) add_rows(table, estimated.results, run.results);
  }
  return table.rows() == 0 ? "" : table.html();
}

}  // namespace grtx::report
