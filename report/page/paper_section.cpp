// SPDX-License-Identifier: Apache-2.0
// Compares the paper's results with runs, and with geometric means over runs that differ only in the view.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "grtx/base/geometric_mean.h"
#include "grtx/explore/sweep/designs.h"
#include "grtx/report/page/charts.h"
#include "grtx/report/page/html.h"
#include "grtx/report/page/paper_targets.h"
#include "grtx/report/page/sections.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;

/// A column of the table: a run, or a mean over several.
struct Column {
  std::string title;
  std::vector<const ReportRun*> runs;

  /// Value of the run, or the geometric mean of several; NaN if one has none.
  double value(const RunTarget& target) const {
    std::vector<double> values;
    for (const ReportRun* run : runs) values.push_back(target.of_run(run->results));
    return geometric_mean(values);
  }
  /// Value of a single run; NaN if it has no checkpointing design, or the cost is unknown.
  double value(const CostTarget& target) const {
    double value = std::numeric_limits<double>::quiet_NaN();
    for (std::size_t i = 0; runs.size() == 1 && i < runs.front()->machines.size(); ++i) {
      const std::string& name = runs.front()->results.designs[i].name;
      const auto design = std::ranges::find(explore::designs(), name, &explore::Design::name);
      const MachineFigures& machine = runs.front()->machines[i];
      if (design == explore::designs().end() || !design->checkpoint || machine.cost.is_null()) continue;
      value = target.of_machine(machine.cost);
    }
    return value;
  }
};

std::vector<Column> columns_of(const std::vector<ReportRun>& runs) {
  std::vector<Column> columns;
  columns.reserve(runs.size());
  for (const ReportRun& run : runs) columns.push_back({run.name.empty() ? "model" : run.name, {&run}});
  for (Views& views : views_of_a_mean(runs)) {
    const std::string machine = views.front()->results.subject.setting("machine");
    columns.push_back({fmt::format("geometric mean of {} views{}", views.size(), machine.empty() ? "" : ", " + machine),
                       std::move(views)});
  }
  return columns;
}

/// In what k the runs of a column differ from the paper; "" if in none.
std::string other_k_of(const RunTarget& target, const Column& column) {
  for (const ReportRun* run : column.runs) {
    if (std::string k = other_k(target, run->results); !k.empty()) return k;
  }
  return "";
}

/// A value with its interval, and in small print its quotient to the paper's value.
std::string with_quotient(const std::string& figure, double quotient) {
  return fmt::format("{} <span class=\"share\">{:.2f}</span>", figure, quotient);
}

/// Rows of area, storage and the like, which have no k.
void add_costs(Table& table, const std::vector<Column>& columns) {
  for (const CostTarget& target : cost_targets()) {
    std::vector<std::string> cells = {escape(target.name), number(target.paper) + " " + target.unit};
    bool any = false;
    for (const Column& column : columns) {
      const double own = column.value(target);
      any = any || std::isfinite(own);
      cells.push_back(std::isfinite(own) ? with_quotient(number(own) + " " + target.unit, own / target.paper) : "");
    }
    if (!any) continue;
    cells.push_back(escape(target.source));
    table.row(cells);
  }
}

/// other_k: said of the bars at another k; empty if there are none.
std::string introduction(const std::string& other_k) {
  std::string html =
      "<p>The paper's means are over six scenes whose copies, trained by ray tracing, are not public. So its ratios "
      "are compared with those on other scenes; a quotient of 1 is not to be expected. Means are geometric, over views "
      "that have machine, options, mode and resolution in common; there are none over others. Storage and buffers are "
      "of the run's own machine, buffers for as many SMs as their row says; the paper's has 8 warps per RT core and "
      "32 resident warps per SM.</p>\n";
  if (other_k.empty()) return html;
  return html + fmt::format(
                    "<p class=\"limit\">Figures {0} say so and have no quotient to the paper's: a run with --k "
                    "{1} has.</p>\n",
                    other_k, paper_k());
}

}  // namespace

std::optional<Interval> interval_of(const RunTarget& target, const RunResults& run) {
  const DesignResult* design = run.design(target.of);
  if (design == nullptr || target.statistic != "gpu.cycles") return std::nullopt;
  if (!target.ratio()) return design->cycles_interval();
  return target.over == run.speedup_over ? run.speedup_interval(*design) : std::nullopt;
}

std::string paper_section(const std::vector<ReportRun>& runs) {
  const std::vector<Column> columns = columns_of(runs);
  std::vector<Table::Column> titles = {{"figure", false}, {"the paper"}};
  std::vector<std::string> labels, series;
  for (const Column& column : columns) {
    titles.push_back({column.title});
    series.push_back(column.title);
  }
  titles.push_back({"place in the paper", false});
  const std::string machines = machines_of(runs), suffix = machines.empty() ? "" : "; " + machines;
  Table table("The paper's figures and the model's, in small the model's over the paper's" + suffix, titles);
  ordered_json bars = ordered_json::array(), ticks = ordered_json::array();
  bool any_other_k = false;
  for (const RunTarget& target : run_targets()) {
    const auto shown = [&](double v) { return !std::isfinite(v) ? "" : target.ratio() ? times(v) : number(v); };
    std::vector<std::string> cells = {escape(target.name), (target.at_least ? "≥ " : "") + shown(target.paper)};
    bool any = false;
    for (const Column& column : columns) {
      const double own = column.value(target);
      cells.push_back("");
      if (!std::isfinite(own)) continue;
      any = true;
      const std::string interval =
          column.runs.size() > 1 ? "" : interval_html(interval_of(target, column.runs.front()->results), times);
      const std::string k = other_k_of(target, column);
      any_other_k = any_other_k || !k.empty();
      cells.back() = k.empty() ? with_quotient(shown(own) + interval, own / target.paper)
                               : fmt::format("{}{} <span class=\"interval\">at {}</span>", shown(own), interval, k);
      if (target.ratio()) bars.push_back({{"label", target.name}, {"series", column.title}, {"value", own}});
    }
    if (!any) continue;
    cells.push_back(escape(target.source));
    table.row(cells);
    if (target.ratio()) {
      labels.push_back(target.name);
      ticks.push_back({{"label", target.name}, {"value", target.paper}});
    }
  }
  add_costs(table, columns);
  if (table.rows() == 0) return "";
  // Bars of machines have the colours that machines have above.
  const bool of_machines = runs.size() > 1 && std::all_of(runs.begin() + 1, runs.end(), [&](const ReportRun& run) {
                             return are_side_by_side(runs.front(), run);
                           });
  const std::string mind = fmt::format("at another k than the paper's {}", paper_k());
  const std::string caption =
      "Ratios of the model (bars) and of the paper (ticks)" + suffix + (any_other_k ? "; bars " + mind : "");
  return "<section id=\"paper\"><h2>The paper and the model</h2>\n" + subjects_html(runs) +
         introduction(any_other_k ? mind : "") +
         (labels.empty() ? ""
                         : chart("paper_ratios", caption, caption,
                                 ratio_bars(bars, ticks, labels, series, "ratio",
                                            of_machines ? SeriesColours::machines : SeriesColours::charts))) +
         table.html() + "</section>\n";
}

}  // namespace grtx::report
