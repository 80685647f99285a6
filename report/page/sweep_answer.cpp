// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/page/sweep_answer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "grtx/base/wrapped.h"
#include "grtx/report/page/html.h"
#include "grtx/report/page/sections.h"
#include "grtx/report/page/sweep_views.h"

namespace grtx::report {
namespace {

/// Points of equal time and area; the first stands for all.
using Equal = std::vector<const ShownPoint*>;

struct Answer {
  std::string view;          ///< "" for a single one
  std::vector<Equal> front;  ///< the fastest first
  std::string area;          ///< whose area: owner_of()
  std::string other;         ///< a sentence on the front over the other area; "" if it has the same points
  const ShownPoint *fastest = nullptr, *smallest = nullptr, *leanest = nullptr;
};

std::string labels(const Equal& points, const char* between = " = ", std::size_t most = 6) {
  std::string text;
  for (std::size_t i = 0; i < points.size() && i < most; ++i) text += (i == 0 ? "" : between) + points[i]->label;
  return text + (points.size() > most ? fmt::format(" and {} more", points.size() - most) : "");
}

std::string other_front(const SweepViews& shown, const SweepResults& results) {
  const std::string area = results.area();
  const char* const other = area == kArea ? explore::kRtUnitArea : kArea;
  const std::vector<std::size_t> front = shown.front(0, other);
  if (front.empty() || front == shown.front(0, area)) return "";
  Equal points;
  for (const std::size_t i : front) points.push_back(&shown.points()[i]);
  const std::string how = results.search.is_null() ? fmt::format(" (area = \"{}\" in the plan)", other) : "";
  return fmt::format("; over the area of {}{} the front is {}", owner_of(other), how, labels(points, ", ", 12));
}

Answer answer_of(const SweepViews& shown, const SweepResults& results) {
  Answer answer;
  const std::string area = results.area();
  answer.area = owner_of(area);
  answer.other = other_front(shown, results);
  if (shown.views().size() > 1) {
    const SweepView& view = shown.views().front();
    answer.view = view.title + (view.is_mean() ? ", geometric means" : "");
  }
  std::vector<const ShownPoint*> front;
  answer.fastest = shown.least(kTime);
  answer.smallest = shown.least(area);
  answer.leanest = shown.least(kEnergy);
  for (const ShownPoint& p : shown.points()) {
    if (p.view == 0 && p.on_area) front.push_back(&p);
  }
  const auto key = [&](const ShownPoint* p) { return std::pair(shown.value(*p, kTime), shown.area(*p)); };
  std::ranges::stable_sort(front, {}, key);
  for (const ShownPoint* p : front) {
    const bool same = !answer.front.empty() && key(answer.front.back().front()) == key(p);
    if (!same) answer.front.emplace_back();
    answer.front.back().push_back(p);
  }
  return answer;
}

std::string time_text(double us) { return with_unit(1e-6 * us, "s"); }

std::string least_text(const Answer& answer) {
  std::string text;
  for (const auto& [what, p] : {std::pair("least time", answer.fastest), std::pair("least area", answer.smallest),
                                std::pair("least energy a ray", answer.leanest)}) {
    if (p != nullptr) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", what, p->label);
  }
  return text;
}

/// What the speed-ups are over: one point, or for each the point of another design or machine.
std::string over_text(const SweepViews& shown, const Answer& answer, const SpeedupOver& reference) {
  if (!reference.design.empty()) return "; speed-up over " + reference.design + " with the same keys";
  if (!reference.on.empty()) return "; speed-up over the same on " + reference.on;
  const ShownPoint* const over = shown.over(*answer.front.front().front(), reference);
  return over == nullptr ? "" : "; speed-up over " + over->label;
}

/// The page's first sentence: the fastest point against the smallest one.
std::string sentence(const SweepViews& shown, const Answer& answer, const SpeedupOver& reference) {
  const ShownPoint &fastest = *answer.fastest, &smallest = *answer.smallest;
  const auto called = [&](const ShownPoint& p) {
    const std::string name = shown.name(shown.first(p), SweepViews::Named::all);
    return breakable(p.label) + (name.empty() ? "" : " (" + breakable(name) + ")");
  };
  if (&fastest == &smallest)
    return fmt::format("<strong>{}</strong> is the fastest point and the smallest.", called(fastest));
  if (shown.over(fastest, reference) == nullptr || shown.over(fastest, reference) != shown.over(smallest, reference)) {
    return fmt::format("<strong>{}</strong> is fastest, {} smallest.", called(fastest), called(smallest));
  }
  return fmt::format(
      "<strong>{}</strong> is fastest: {:.2f} times as fast as {}, the smallest, for {:.1f} % more area of {}.",
      called(fastest), shown.value(smallest, kTime) / shown.value(fastest, kTime), called(smallest),
      100.0 * (shown.area(fastest) / shown.area(smallest) - 1.0), answer.area);
}

}  // namespace

std::string sweep_answer_text(const SweepResults& results) {
  constexpr std::size_t kMost = 12;  // lines of a terminal
  const SweepViews shown(results);
  const Answer answer = answer_of(shown, results);
  if (answer.front.empty()) return "";
  const SpeedupOver reference = shown.reference();
  std::string text = fmt::format(
      "\nfront of time against the area of {}{}{}\n{:>12} {:>10} {:>12} {:>11} {:>9}  point\n", answer.area,
      answer.view.empty() ? "" : ": ", answer.view, "time", "chip, mm2", "RT unit, mm2", "nJ a ray", "speed-up");
  for (std::size_t i = 0; i < answer.front.size() && i < kMost; ++i) {
    const ShownPoint& p = *answer.front[i].front();
    const double speedup = shown.speedup(p, reference), us = shown.value(p, kTime);
    text += fmt::format("{:>12} {:>10.3f} {:>12.4f} {:>11.4g} {:>9}  {}\n",
                        us < 1e3 ? fmt::format("{:.1f} us", us) : fmt::format("{:.3f} ms", us * 1e-3),
                        shown.value(p, kArea), shown.value(p, explore::kRtUnitArea), shown.value(p, kEnergy),
                        std::isfinite(speedup) ? fmt::format("{:.2f}", speedup) : "", labels(answer.front[i]));
    if (const std::string name = shown.name(shown.first(p), SweepViews::Named::all); !name.empty()) {
      text += wrapped("    " + name, 4) + "\n";
    }
  }
  if (answer.front.size() > kMost) text += fmt::format("  and {} more\n", answer.front.size() - kMost);
  return text +
         wrapped("each is the fastest of its area or less; " + least_text(answer) +
                 over_text(shown, answer, reference) + answer.other) +
         "\n";
}

std::string sweep_answer_html(const SweepResults& results) {
  const SweepViews shown(results);
  const Answer answer = answer_of(shown, results);
  if (answer.front.empty()) return "";
  const SpeedupOver reference = shown.reference();
  const std::string machines = machines_of(results);
  Table table(
      results.file + ": the front of time against the area of " + answer.area +
          (answer.view.empty() ? "" : ", " + answer.view) + "; each is the fastest of its area or less" +
          (machines.empty() ? "" : "; " + machines),
      {{"point"}, {"time"}, {"chip, mm²"}, {"RT unit, mm²"}, {"energy a ray"}, {"speed-up"}, {"what it is", false}});
  for (const Equal& equal : answer.front) {
    const ShownPoint& p = *equal.front();
    table.row({escape(labels(equal)),
               time_text(shown.value(p, kTime)) + interval_html(shown.time_interval(p), time_text),
               number(shown.value(p, kArea)), number(shown.value(p, explore::kRtUnitArea)),
               with_unit(1e-9 * shown.value(p, kEnergy), "J"), times(shown.speedup(p, reference)),
               escape(shown.name(shown.first(p), SweepViews::Named::all))});
  }
  return "<p class=\"answer\">" + sentence(shown, answer, reference) + "</p>\n" + table.html() + "<p class=\"note\">" +
         escape(least_text(answer) + over_text(shown, answer, reference) + answer.other) + ".</p>\n";
}

}  // namespace grtx::report
