// SPDX-License-Identifier: Apache-2.0
// Description of a sweep's points, and its headline results.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "grtx/report/page/html.h"
#include "grtx/report/page/sections.h"
#include "grtx/report/page/sweep_answer.h"
#include "grtx/report/page/sweep_views.h"

namespace grtx::report {
namespace {

/// The largest speed-up over a comparable point.
std::string largest_speedup(const SweepViews& shown) {
  const SpeedupOver reference = shown.reference();
  const ShownPoint* best = nullptr;
  for (const ShownPoint& p : shown.points()) {
    const double own = shown.speedup(p, reference);
    if (p.view != 0 || !std::isfinite(own)) continue;
    if (best == nullptr || own > shown.speedup(*best, reference)) best = &p;
  }
  if (best == nullptr || shown.over(*best, reference) == best) return "";
  const std::string value =
      times(shown.speedup(*best, reference)) + interval_html(shown.speedup_interval(*best, reference), times);
  return headline(value, "Largest speed-up",
                  fmt::format("{} over {}{}", shown.full_label(*best), shown.full_label(*shown.over(*best, reference)),
                              reference.design.empty() && reference.on.empty() ? "" : ", the same keys"));
}

}  // namespace

std::string machines_of(const SweepResults& results) {
  std::vector<Subject> subjects;
  for (const ReportedPoint& p : results.points) {
    if (p.done()) subjects.push_back(subject_of(results, p));
  }
  return machines_text(subjects);
}

std::string subject_html(const SweepResults& results, const std::string& id, bool limits) {
  std::string out;
  if (const std::string machines = machines_of(results); !machines.empty())
    out = "<p class=\"subject\">" + escape(machines) + ".</p>\n";
  std::vector<std::pair<sim::ResultNote, std::vector<std::int64_t>>>
      notes;  // {first note of each id, ids of its points}
  std::size_t done = 0;
  for (const ReportedPoint& p : results.points) {
    done += p.done() ? 1 : 0;
    for (const sim::ResultNote& note : p.notes) {
      const auto known = std::find_if(notes.begin(), notes.end(), [&](const auto& n) { return n.first.id == note.id; });
      (known == notes.end() ? notes.emplace_back(note, std::vector<std::int64_t>()) : *known).second.push_back(p.id);
    }
  }
  if (notes.empty()) return out;
  const std::string chip = id + "_limits";
  if (!limits) return out + fmt::format("<p class=\"note\"><a href=\"#{}\">What limits these figures</a></p>\n", chip);
  std::string all;
  for (const auto& [note, points] : notes) {
    const std::string whose = fmt::format("{}: {} of {} points; #{}", note.id, points.size(), done, points.front());
    all += notes_html({{whose, {note}}});
  }
  return out + notes_chip(notes.size(), all, chip);
}

std::string sweep_headline(const ReportSweep& sweep) {
  const SweepResults& results = sweep.results;
  const SweepViews shown(results);
  std::map<std::string, std::size_t> states;
  for (const ReportedPoint& p : results.points) ++states[p.status];
  std::string other;
  for (const auto& [status, count] : states) {
    if (status != "done") other += fmt::format("{}{} {}", other.empty() ? "" : ", ", count, status);
  }
  if (!results.earlier.empty()) {
    other += fmt::format("{}{} of an earlier plan left out", other.empty() ? "" : ", ", results.earlier.size());
  }
  std::string cards = headline(fmt::format("{} / {}", states["done"], results.points.size()), "Points done", other);
  const std::string values[3] = {kTime, results.area(), kEnergy};
  const std::string owner = owner_of(results.area());
  const std::string names[3] = {"Least time", "Least area of " + owner, "Least energy a ray"};
  const char* const units[3] = {" µs", " mm²", " nJ"};
  const auto on_front = [](const ShownPoint& p) { return p.view == 0 && p.on_area; };
  const auto front = std::ranges::count_if(shown.points(), on_front);
  for (unsigned i = 0; i < 3; ++i) {
    const ShownPoint* best = shown.least(values[i]);
    if (best == nullptr) continue;
    const auto interval = i == 0 ? shown.time_interval(*best) : std::nullopt;
    cards += headline(number(shown.value(*best, values[i])) + units[i] + interval_html(interval, number), names[i],
                      shown.full_label(*best));
    if (i == 0) cards += largest_speedup(shown);
  }
  cards += headline(number(static_cast<double>(front)), "Points on the front", "of time against the area of " + owner);
  const bool mean = !shown.views().empty() && shown.views().front().is_mean();
  const std::string views = mean ? fmt::format(": {}, geometric means", shown.views().front().title)
                            : shown.views().size() > 1 ? ": " + shown.views().front().title
                                                       : "";
  return fmt::format("<h3>{}{}</h3>\n{}{}<dl class=\"cards\">\n{}</dl>\n", escape(results.file), escape(views),
                     subject_html(results, sweep.id, true), sweep_answer_html(results), cards);
}

}  // namespace grtx::report
