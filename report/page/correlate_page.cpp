// SPDX-License-Identifier: Apache-2.0
// The page of grtx correlate: a scatter plot with ranges, and a table.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "grtx/report/page/charts.h"
#include "grtx/report/page/correlate.h"
#include "grtx/report/page/html.h"
#include "grtx/report/page/page.h"
#include "grtx/report/page/sections.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;

std::string with_range(double value, double low, double high) {
  return low == high ? number(value) : number(value) + " (" + number(low) + " to " + number(high) + ")";
}

std::string percent(double share) { return fmt::format("{:.0f} %", 100.0 * share); }

}  // namespace

std::string correlation_page(const Correlation& c, const std::string& measured, const SweepResults& sweep) {
  std::string body = "<section id=\"headline\"><h2>Headline figures</h2>\n" + subject_html(sweep, "sweep", true) +
                     "<dl class=\"cards\">\n";
  body += headline(percent(c.mean_error), "mean error", "of simulated against measured");
  body += headline(times(c.factor), "common factor", percent(c.scaled_error) + " mean error beyond it");
  if (std::isfinite(c.spearman)) {
    body += headline(fmt::format("{:.2f}", c.spearman), "Spearman", "Kendall " + fmt::format("{:.2f}", c.kendall));
  }
  body += "</dl>\n</section>\n<section id=\"scatter\"><h2>Measured and simulated</h2>\n";
  ordered_json rows = ordered_json::array();
  const std::string machines = machines_of(sweep);
  const bool any_error = std::ranges::any_of(c.comparisons, [](const Comparison& o) { return o.standard_error > 0.0; });
  std::vector<Table::Column> columns = {{"figure", false}, {"measured"}, {"simulated"}, {"error"}};
  if (any_error) columns.push_back({"standard errors"});
  columns.push_back({"in the measured range", false});
  Table table("Measured against simulated" + (machines.empty() ? "" : "; " + machines), columns);
  for (const Comparison& one : c.comparisons) {
    const bool outlier = std::find(c.outliers.begin(), c.outliers.end(), one.label) != c.outliers.end();
    rows.push_back(comparison_json(one));
    rows.back()["kind"] = outlier ? "outlier" : "figure";
    rows.back()["number"] = rows.size();  // at its point and in the table
    std::string name = fmt::format("{}. ", rows.size()) + escape(one.label);
    if (!one.paired) name += fmt::format(" (means of {} and {} scenes)", one.measured_scenes, one.simulated_scenes);
    std::vector<std::string> cells = {name, with_range(one.measured, one.measured_low, one.measured_high),
                                      with_range(one.simulated, one.simulated_low, one.simulated_high),
                                      fmt::format("{:+.0f} %", 100.0 * one.error())};
    if (any_error) cells.push_back(one.standard_error > 0.0 ? fmt::format("{:+.1f}", one.deviations()) : "");
    cells.push_back(one.inside_words() + std::string(outlier ? ", outlier" : ""));
    table.row(cells);
  }
  body += chart("scatter-chart", "Simulated against measured figures", "On the line both are the same.",
                correlation_chart(rows));
  body += table.html();
  for (const std::string& label : c.unmatched) body += "<p>Not simulated: " + escape(label) + "</p>\n";
  body += "</section>\n<section id=\"inputs\"><h2>Inputs</h2>\n<p>Measured: " + escape(measured) +
          ". Simulated: " + escape(sweep.file) + ", " + escape(sweep.hash) + " (of its points).</p></section>\n";
  return html_page("Measured and simulated: " + measured, "correlate", body);
}

}  // namespace grtx::report
