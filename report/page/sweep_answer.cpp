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
  const ShownPoint *fastest = nullptr, *smallest = nullptr, *leanest = nullptr;
};

Answer answer_of(const SweepViews& shown) {
  Answer answer;
  if (shown.views().size() > 1) {
    const SweepView& view = shown.views().front();
    answer.view = view.title + (view.is_mean() ? ", geometric means" : "");
  }
  std::vector<const ShownPoint*> front;
  answer.fastest = shown.least(kTime);
  answer.smallest = shown.least(kArea);
  answer.leanest = shown.least(kEnergy);
  for (const ShownPoint& p : shown.points()) {
    if (p.view == 0 && p.on_area) front.push_back(&p);
  }
  const auto key = [&](const ShownPoint* p) { return std::pair(shown.value(*p, kTime), shown.value(*p, kArea)); };
  std::ranges::stable_sort(front, {}, key);
  for (const ShownPoint* p : front) {
    const bool same = !answer.front.empty() && key(answer.front.back().front()) == key(p);
    if (!same) answer.front.emplace_back();
    answer.front.back().push_back(p);
  }
  return answer;
}

std::string time_text(double us) { return with_unit(1e-6 * us, "s"); }

std::string labels(const Equal& points, std::size_t most = 6) {
  std::string text;
  for (std::size_t i = 0; i < points.size() && i < most; ++i) text += (i == 0 ? "" : " = ") + points[i]->label;
  return text + (points.size() > most ? fmt::format(" and {} more", points.size() - most) : "");
}

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
      "<strong>{}</strong> is fastest: {:.2f} times as fast as {}, the smallest, for {:.1f} % more area.",
      called(fastest), shown.value(smallest, kTime) / shown.value(fastest, kTime), called(smallest),
      100.0 * (shown.value(fastest, kArea) / shown.value(smallest, kArea) - 1.0));
}

}  // namespace

std::string sweep_answer_text(const SweepResults& results) {
  constexpr std::size_t kMost = 12;  // lines of a terminal
  const SweepViews shown(results);
  const Answer answer = answer_of(shown);
  if (answer.front.empty()) return "";
  const SpeedupOver reference = shown.reference();
  std::string text = "\nfront of time against area" + (answer.view.empty() ? "" : ": " + answer.view) + "\n" +
                     fmt::format("{:>12} {:>10} {:>11} {:>9}  point\n", "time", "mm2", "nJ a ray", "speed-up");
  for (std::size_t i = 0; i < answer.front.size() && i < kMost; ++i) {
    const ShownPoint& p = *answer.front[i].front();
    const double speedup = shown.speedup(p, reference), us = shown.value(p, kTime);
    text += fmt::format("{:>12} {:>10.3f} {:>11.4g} {:>9}  {}\n",
                        us < 1e3 ? fmt::format("{:.1f} us", us) : fmt::format("{:.3f} ms", us * 1e-3),
                        shown.value(p, kArea), shown.value(p, kEnergy),
                        std::isfinite(speedup) ? fmt::format("{:.2f}", speedup) : "", labels(answer.front[i]));
    if (const std::string name = shown.name(shown.first(p), SweepViews::Named::all); !name.empty()) {
      text += wrapped("    " + name, 4) + "\n";
    }
  }
  if (answer.front.size() > kMost) text += fmt::format("  and {} more\n", answer.front.size() - kMost);
  return text +
         wrapped("each is the fastest of its area or less; " + least_text(answer) +
                 over_text(shown, answer, reference)) +
         "\n";
}

std::string sweep_answer_html(const SweepResults& results) {
  const SweepViews shown(results);
  const Answer answer = answer_of(shown);
  if (answer.front.empty()) return "";
  const SpeedupOver reference = shown.reference();
  const std::string machines = machines_of(results);
  Table table(results.file + ": the front of time against area" + (answer.view.empty() ? "" : ", " + answer.view) +
                  "; each is the fastest of its area or less" + (machines.empty() ? "" : "; " + machines),
              {{"point"}, {"time"}, {"mm²"}, {"energy a ray"}, {"speed-up"}, {"what it is", false}});
  for (const Equal& equal : answer.front) {
    const ShownPoint& p = *equal.front();
    table.row({escape(labels(equal)),
               time_text(shown.value(p, kTime)) + interval_html(shown.time_interval(p), time_text),
               number(shown.value(p, kArea)), with_unit(1e-9 * shown.value(p, kEnergy), "J"),
               times(shown.speedup(p, reference)), escape(shown.name(shown.first(p), SweepViews::Named::all))});
  }
  return "<p class=\"answer\">" + sentence(shown, answer, reference) + "</p>\n" + table.html() + "<p class=\"note\">" +
         escape(least_text(answer) + over_text(shown, answer, reference)) + ".</p>\n";
}

}  // namespace grtx::report
