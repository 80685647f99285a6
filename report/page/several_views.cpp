// SPDX-License-Identifier: Apache-2.0
// The answer over several views: which design is fastest in all of them, and each speed-up's geometric mean.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "grtx/base/geometric_mean.h"
#include "grtx/report/page/html.h"
#include "grtx/report/page/launch_size.h"
#include "grtx/report/page/sections.h"

namespace grtx::report {
namespace {

std::string all_of(const Views& views) {
  return views.size() == 2 ? "both views" : fmt::format("all {} views", views.size());
}

/// Whether two runs may be averaged: they differ only in the view.
bool shares_mean(const ReportRun& a, const ReportRun& b) {
  const Subject &own = a.results.subject, &other = b.results.subject;
  return own.unknown().empty() && other.unknown().empty() && own.view_text() != other.view_text() &&
         own.differences(other, MayDiffer::views).empty();
}

/// Speed-ups of a design over the reference, a value per view.
struct Speedups {
  std::string design;
  std::vector<double> values;

  double mean() const { return geometric_mean(values); }
};

/// Of the designs that all of the runs have; empty without a reference that all share.
std::vector<Speedups> speedups_of(const Views& views) {
  const std::string& over = views.front()->results.speedup_over;
  std::vector<Speedups> list;
  for (const DesignResult& design : views.front()->results.designs) {
    Speedups own{design.name, {}};
    for (const ReportRun* run : views) {
      const DesignResult *here = run->results.design(design.name), *reference = run->results.design(over);
      if (here == nullptr || reference == nullptr || run->results.speedup_over != over) break;
      own.values.push_back(reference->value("gpu.cycles") / here->value("gpu.cycles"));
    }
    if (own.values.size() == views.size() && std::isfinite(own.mean())) list.push_back(std::move(own));
  }
  return list;
}

/// "walk is fastest in both views: 27.38 times as fast as baseline in the geometric mean (24.25× to 30.91×)."
std::string sentence(const Views& views, const Speedups& best) {
  const auto wins =
      std::ranges::count_if(views, [&](const ReportRun* run) { return fastest(run->results).name == best.design; });
  const std::string where = static_cast<std::size_t>(wins) == views.size()
                                ? "in " + all_of(views)
                                : fmt::format("in {} of {} views, and in their mean", wins, views.size());
  const auto [least, most] = std::ranges::minmax(best.values);
  std::string text = fmt::format("<strong>{} is fastest {}</strong>", escape(best.design), where);
  if (best.design != views.front()->results.speedup_over) {
    text += fmt::format(": <strong>{:.2f} times as fast as {}</strong> in the geometric mean ({} to {})", best.mean(),
                        escape(views.front()->results.speedup_over), times(least), times(most));
  }
  text += ".";
  const auto small = std::ranges::count_if(
      views, [](const ReportRun* run) { return !too_small_text(launch_sizes(run->results), "designs").empty(); });
  if (small > 0) {
    text += fmt::format(" <strong class=\"bad\">Mind: {} of the images {} too small to compare designs.</strong>",
                        small, small == 1 ? "is" : "are");
  }
  return text;
}

}  // namespace

std::vector<Views> views_of_a_mean(const std::vector<ReportRun>& runs) {
  std::vector<Views> groups;
  for (const ReportRun& run : runs) {
    const auto fits = [&](const Views& group) {
      return std::all_of(group.begin(), group.end(), [&](const ReportRun* one) { return shares_mean(*one, run); });
    };
    const auto group = std::find_if(groups.begin(), groups.end(), fits);
    if (group == groups.end()) {
      groups.push_back({&run});
    } else {
      group->push_back(&run);
    }
  }
  std::erase_if(groups, [](const Views& group) { return group.size() < 2; });
  return groups;
}

std::string several_views_html(const std::vector<ReportRun>& runs) {
  std::string out;
  for (const Views& views : views_of_a_mean(runs)) {
    const std::vector<Speedups> speedups = speedups_of(views);
    if (speedups.size() < 2) continue;
    const Speedups& best = *std::ranges::max_element(speedups, {}, &Speedups::mean);
    const Subject& subject = views.front()->results.subject;
    std::vector<Table::Column> columns = {{"design", false}};
    for (const ReportRun* run : views) columns.push_back({run->name});
    columns.push_back({"geometric mean"});
    Table table("Speed-up over " + views.front()->results.speedup_over + " in each view; " + subject.machine_text(),
                columns);
    for (const Speedups& own : speedups) {
      std::vector<std::string> cells = {escape(own.design)};
      for (const double value : own.values) cells.push_back(times(value));
      cells.push_back(times(own.mean()));
      table.row(cells);
    }
    std::string title = all_of(views);
    title.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(title.front())));
    out += fmt::format("<h3>{}</h3>\n<p class=\"answer\">{}</p>\n", title, sentence(views, best)) + table.html();
  }
  return out;
}

}  // namespace grtx::report
