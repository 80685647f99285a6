// SPDX-License-Identifier: Apache-2.0
// The section on a sweep, view by view: Pareto fronts, table of points, stalls and energy of chosen points, effects of
// the coordinates.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "grtx/base/json.h"
#include "grtx/lab/sweep/axis.h"
#include "grtx/view/report/charts.h"
#include "grtx/view/report/html.h"
#include "grtx/view/report/mode_agreement.h"
#include "grtx/view/report/sections.h"
#include "grtx/view/report/sweep_views.h"

namespace grtx::view {
namespace {

using nlohmann::ordered_json;

/// The point's machine, design and coordinates in words: "paper, grtx, l1.bytes = 65536".
std::string words(const ReportedPoint& p) {
  std::string text = p.machine + (p.machine.empty() || p.design.empty() ? "" : ", ") + p.design;
  for (const auto& [name, value] : p.coordinates.items()) {
    text += (text.empty() ? "" : ", ") + name + " = " + lab::text_of(value);
  }
  return text;
}

/// Columns that distinguish the points of a view: machine and design if they vary, then the varying coordinates.
struct Describing {
  std::string title;
  std::function<ordered_json(const ReportedPoint&)> of;
};
std::vector<Describing> describing(const SweepResults& sweep, const SweepViews& shown) {
  std::vector<Describing> list;
  if (sweep.several(&ReportedPoint::machine)) {
    list.push_back({"machine", [](const ReportedPoint& p) { return ordered_json(p.machine); }});
  }
  if (sweep.several(&ReportedPoint::design)) {
    list.push_back({"design", [](const ReportedPoint& p) { return ordered_json(p.design); }});
  }
  for (const std::string& name : shown.varying()) {
    list.push_back({name, [name](const ReportedPoint& p) {
                      return p.coordinates.contains(name) ? p.coordinates.at(name) : ordered_json();
                    }});
  }
  return list;
}

/// Ids of the notes on a point; for a mean, those of all its points.
std::string note_ids(const SweepResults& results, const ShownPoint& point) {
  std::vector<std::string> ids;
  for (const std::size_t i : point.of) {
    for (const sim::ResultNote& note : results.points[i].notes) {
      if (std::find(ids.begin(), ids.end(), note.id) == ids.end()) ids.push_back(note.id);
    }
  }
  std::string text;
  for (const std::string& id : ids) text += (text.empty() ? "" : ", ") + id;
  return text;
}

constexpr std::size_t kTooltip = 5;  // maximum columns; with more, the point's name is shown instead

std::string pareto_html(const ReportSweep& sweep, const SweepViews& shown, const std::vector<Describing>& columns,
                        const ChartField& cost, const std::string& what) {
  ordered_json rows = ordered_json::array();
  std::vector<ChartField> tooltip = {{"label", "point"}};
  for (const ShownPoint& point : shown.points()) {
    const double time = shown.value(point, kTime), own = shown.value(point, cost.field);
    if (!std::isfinite(time) || !std::isfinite(own)) continue;
    const ReportedPoint& p = shown.first(point);
    ordered_json row = {{"id", point.id},
                        {"label", point.label},
                        {"name", shown.name(p)},
                        {"time", time},
                        {"cost", own},
                        {"front", cost.field == kArea ? point.on_area : point.on_energy},
                        {"view", point.view},
                        {"none", "all points"},
                        {"interval", interval_text(shown.time_interval(point), number)},
                        {"notes", note_ids(sweep.results, point)}};
    // Rows use numbered fields: names of coordinates contain dots, which Vega-Lite reads as paths.
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const ordered_json value = columns[c].of(p);
      row[fmt::format("c{}", c)] = value.is_structured() ? ordered_json(json_text(value)) : value;
    }
    rows.push_back(std::move(row));
  }
  if (rows.empty()) return "";
  const auto any = [&rows](const char* field) {
    return std::any_of(rows.begin(), rows.end(), [field](const ordered_json& row) { return row.at(field) != ""; });
  };
  if (columns.size() > kTooltip) tooltip.push_back({"name", "differs in"});
  for (std::size_t c = 0; c < columns.size() && columns.size() <= kTooltip; ++c) {
    tooltip.push_back({fmt::format("c{}", c), columns[c].title});
  }
  tooltip.push_back({"time", "time, µs", true});
  if (any("interval")) tooltip.push_back({"interval", "95 % interval of it"});
  tooltip.push_back({"cost", cost.title, true});
  if (any("notes")) tooltip.push_back({"notes", "mind"});
  const std::string caption = what + " against simulated time, " + machines_of(sweep.results) +
                              ". Points on the front are large, on the dashed line. Hover for the "
                              "configuration; drag a box to choose points, double-click to choose all.";
  return chart(sweep.id + "_" + (cost.field == kArea ? "area" : "energy"), what + " against time, one mark a point",
               caption,
               pareto_chart(rows, {"time", "time, µs"}, {"cost", cost.title}, tooltip, columns.empty() ? "none" : "c0"),
               "pareto", sweep.id);
}

std::string bars_html(const ReportSweep& sweep, const SweepViews& shown, const std::string& prefix,
                      const std::string& id, const std::string& value_title, const std::string& caption) {
  ordered_json rows = ordered_json::array();
  std::vector<std::string> parts;
  for (const ShownPoint& point : shown.points()) {
    std::vector<std::pair<std::string, double>> own;
    if (prefix == "gpu.rt.stall.") own.emplace_back("issue", shown.sum(point, "gpu.rt.selections"));
    const ReportedPoint& p = shown.first(point);
    for (auto it = p.values.lower_bound(prefix); it != p.values.end() && it->first.starts_with(prefix); ++it) {
      if (it->first.find('.', prefix.size()) == std::string::npos) {
        own.emplace_back(it->first.substr(prefix.size()), shown.sum(point, it->first));
      }
    }
    double sum = 0.0;
    for (const auto& [part, value] : own) sum += value;
    for (const auto& [part, value] : own) {
      if (!(value > 0.0)) continue;
      if (std::find(parts.begin(), parts.end(), part) == parts.end()) parts.push_back(part);
      rows.push_back({{"id", point.id},
                      {"label", shown.full_label(point)},
                      {"order", shown.value(point, kTime)},
                      {"front", point.on_front()},
                      {"view", point.view},
                      {"part", part},
                      {"value", value},
                      {"share", value / sum}});
    }
  }
  if (rows.empty()) return "";
  return chart(sweep.id + "_" + id + "_bars", caption, caption, stacked_bars(rows, parts, value_title, "part", true),
               "bars", sweep.id);
}

/// Columns of the table: results first, then the point's coordinates.
std::string points_table(const ReportSweep& sweep, const SweepViews& shown, const std::vector<Describing>& columns) {
  const bool several = shown.views().size() > 1;
  std::vector<Table::Column> titles = {{"point"}};
  if (several) titles.push_back({"view", false});
  for (const char* title : {"time, µs", "speed-up", "mm²", "nJ a ray"}) titles.push_back({title});
  titles.push_back({"on the front of", false});
  for (const char* title : {"cycles", "L1 hit rate", "DRAM MB", "mm², low – high"}) titles.push_back({title});
  for (const Describing& column : columns) titles.push_back({column.title});
  const auto noted = [&](const ShownPoint& point) { return !note_ids(sweep.results, point).empty(); };
  const bool any_notes = std::any_of(shown.points().begin(), shown.points().end(), noted);
  if (any_notes) titles.push_back({"mind", false});
  Table table(sweep.results.file + ": finished points, " + machines_of(sweep.results), titles, sweep.id + "_points");
  const SpeedupOver reference = shown.reference();
  std::vector<std::string> machines;
  for (const ShownPoint& point : shown.points()) {
    const ReportedPoint& p = shown.first(point);
    const auto value = [&](const char* name) { return shown.value(point, name); };
    std::vector<std::string> cells = {point.label};
    if (several) cells.push_back(escape(shown.views()[point.view].title));
    cells.push_back(number(value(kTime)) + interval_html(shown.time_interval(point), number));
    const std::optional<Interval> interval = shown.speedup_interval(point, reference);
    cells.push_back("<span class=\"speedup\">" + times(shown.speedup(point, reference)) +
                    interval_html(interval, times) + "</span>");
    cells.push_back(number(value(kArea)));
    cells.push_back(number(value(kEnergy)));
    cells.push_back(point.on_area ? (point.on_energy ? "mm², nJ" : "mm²") : point.on_energy ? "nJ" : "");
    cells.push_back(number(value("gpu.cycles")));
    const double hits = value("gpu.l1.node.hit_rate");
    cells.push_back(std::isfinite(hits) ? fmt::format("{:.1f} %", 100.0 * hits) : "");
    cells.push_back(number(value("gpu.dram.bytes") * 1e-6));
    const double low = value("cost.mm2_low"), high = value("cost.mm2_high");
    cells.push_back(std::isfinite(low) && std::isfinite(high) ? number(low) + " – " + number(high) : "");
    for (const Describing& column : columns) cells.push_back(cell(column.of(p)));
    if (any_notes) cells.push_back(escape(note_ids(sweep.results, point)));
    if (std::find(machines.begin(), machines.end(), p.machine) == machines.end()) machines.push_back(p.machine);
    const auto base = std::find(machines.begin(), machines.end(), p.machine) - machines.begin();
    const std::optional<Interval> time = shown.time_interval(point);
    table.row(cells,
              fmt::format(" data-id=\"{}\" data-view=\"{}\" data-machine=\"{}\" data-keys=\"{}\" data-base=\"{}\" "
                          "data-design=\"{}\" data-time=\"{}\"{}{}",
                          point.id, point.view, point.machine, point.keys, base, escape(p.design), value(kTime),
                          time ? fmt::format(" data-low=\"{}\" data-high=\"{}\"", time->low, time->high) : "",
                          point.on_front() ? " class=\"front\"" : ""));
  }
  return table.rows() == 0 ? "" : table.html();
}

std::string unfinished_table(const SweepResults& results) {
  Table table(results.file + ": points without a result",
              {{"point"}, {"what", false}, {"status", false}, {"reason", false}});
  for (const ReportedPoint& p : results.points) {
    if (p.done()) continue;
    table.row({fmt::format("#{}", p.id), escape(words(p)), escape(p.status), escape(p.reason)});
  }
  return table.rows() == 0 ? "" : table.html();
}

double median(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

/// Effect of each coordinate: compares its values over the points of the first view, per machine and design.
std::string effects_table(const SweepResults& results, const SweepViews& shown,
                          const std::vector<Describing>& columns) {
  if (shown.points().empty()) return "";
  const std::string of = shown.views().size() > 1 ? shown.views().front().title + ", " : "";
  Table table(results.file + ": what each value does, " + of + machines_of(results), {{"machine and design", false},
                                                                                      {"coordinate", false},
                                                                                      {"value"},
                                                                                      {"points"},
                                                                                      {"least time, µs"},
                                                                                      {"median time, µs"},
                                                                                      {"median mm²"},
                                                                                      {"median nJ a ray"}});
  std::map<std::pair<std::string, std::string>, std::vector<const ShownPoint*>> alike;  // by machine and design
  for (const ShownPoint& point : shown.points()) {
    if (point.view == 0) alike[{shown.first(point).machine, shown.first(point).design}].push_back(&point);
  }
  for (const auto& [own, points] : alike) {
    const std::string name = own.first + (own.first.empty() ? "" : ", ") + own.second;
    for (const Describing& column : columns) {
      std::map<ordered_json, std::vector<const ShownPoint*>> by_value;
      for (const ShownPoint* point : points) by_value[column.of(shown.first(*point))].push_back(point);
      if (by_value.size() < 2) continue;
      for (const auto& [value, having] : by_value) {
        std::vector<double> time, area, energy;
        for (const ShownPoint* point : having) {
          time.push_back(shown.value(*point, kTime));
          area.push_back(shown.value(*point, kArea));
          energy.push_back(shown.value(*point, kEnergy));
        }
        table.row({escape(name), escape(column.title), cell(value), number(static_cast<double>(time.size())),
                   number(*std::min_element(time.begin(), time.end())), number(median(time)), number(median(area)),
                   number(median(energy))});
      }
    }
  }
  return table.rows() == 0 ? "" : table.html();
}

std::string agreement_table(const SweepResults& results) {
  Table table(results.file + ": points that two modes have simulated, " + machines_of(results),
              {{"scene", false},
               {"mode", false},
               {"against", false},
               {"points"},
               {"time, mean ratio"},
               {"least ratio"},
               {"largest ratio"},
               {"rank correlation (Kendall's tau)"}});
  for (const ModeAgreement& a : mode_agreements(results)) {
    const auto ratio = [](double value) { return fmt::format("{:.3f}", value); };
    table.row({escape(a.scene), escape(a.mode), escape(a.against), number(static_cast<double>(a.points)),
               ratio(a.mean_ratio), ratio(a.least_ratio), ratio(a.largest_ratio),
               std::isfinite(a.tau) ? ratio(a.tau) : "all times equal"});
  }
  return table.rows() == 0 ? "" : table.html();
}

std::string traces_table(const SweepResults& results) {
  Table table(results.file + ": traces",
              {{"key", false}, {"scene", false}, {"options", false}, {"bytes"}, {"status", false}, {"reason", false}});
  for (const ReportedTrace& t : results.traces) {
    table.row({escape(t.key), escape(t.scene), escape(t.options), number(static_cast<double>(t.bytes)),
               escape(t.status), escape(t.reason)});
  }
  return table.rows() == 0 ? "" : details("Traces", table.html());
}

/// Controls for the reader: view, reference of speed-ups, colour.
std::string controls(const ReportSweep& sweep, const SweepViews& shown, const std::vector<Describing>& columns) {
  std::string views, points, colours;
  for (std::size_t v = 0; shown.views().size() > 1 && v < shown.views().size(); ++v) {
    views += fmt::format("<option value=\"{}\">{}</option>", v, escape(shown.views()[v].title));
  }
  if (!views.empty()) views = "<label>View <select class=\"view\">" + views + "</select></label> ";
  const SpeedupOver at_first = shown.reference();
  const auto option = [&](const std::string& value, const SpeedupOver& over, const std::string& label) {
    points += fmt::format("<option value=\"{}\"{}>{}</option>", escape(value), over == at_first ? " selected" : "",
                          escape(label));
  };
  std::vector<std::string> designs;
  for (const ShownPoint& point : shown.points()) {
    const std::string& design = shown.first(point).design;
    if (std::find(designs.begin(), designs.end(), design) == designs.end()) designs.push_back(design);
  }
  for (const std::string& design : designs) {
    if (designs.size() > 1) option("design:" + design, {design, 0}, design + " with the same keys");
  }
  std::vector<std::size_t> known;
  for (const ShownPoint& point : shown.points()) {
    if (std::find(known.begin(), known.end(), point.machine) != known.end()) continue;
    known.push_back(point.machine);
    option(fmt::format("point:{}", point.machine), {"", point.machine}, shown.full_label(point));
  }
  for (std::size_t c = 0; c < columns.size(); ++c) {
    colours += fmt::format("<option value=\"c{}\">{}</option>", c, escape(columns[c].title));
  }
  colours += "<option value=\"none\">nothing</option>";
  return fmt::format(
      "<p class=\"controls\" data-group=\"{}\" hidden>{}<label>Speed-up over <select "
      "class=\"reference\">{}</select></label> <label>Colour by <select class=\"colour\">{}</select></label> "
      "<button type=\"button\" class=\"all\">Choose all points</button> "
      "<span class=\"chosen\" role=\"status\"></span></p>\n",
      sweep.id, views, points, colours);
}

}  // namespace

std::string sweep_section(const ReportSweep& sweep) {
  const SweepResults& results = sweep.results;
  const SweepViews shown(results);
  const std::vector<Describing> columns = describing(results, shown);
  std::string out = fmt::format("<section id=\"{}\" class=\"sweep\"><h2>Sweep {}</h2>\n{}", sweep.id,
                                escape(results.file), subject_html(results));
  if (shown.views().size() > 1) {
    out +=
        shown.views().front().is_mean()
            ? "<p>Points are compared within a view of a scene. \"All views\" has geometric means of the points that "
              "were simulated in each of them.</p>\n"
            : "<p>Points are compared within a view of a scene. No point was simulated in all of them, so there is "
              "no mean.</p>\n";
  }
  const std::string area = pareto_html(sweep, shown, columns, {kArea, "mm²"}, "Area");
  const std::string energy = pareto_html(sweep, shown, columns, {kEnergy, "nJ a ray"}, "Energy of a ray");
  if (!shown.points().empty()) out += controls(sweep, shown, columns);
  out += "<div class=\"pair\">" + area + energy + "</div>\n";
  out += points_table(sweep, shown, columns);
  out += "<div class=\"pair\">" +
         bars_html(sweep, shown, "gpu.rt.stall.", "stalls", "cycles of all RT units",
                   "Cycles of the RT units of the chosen points (until you choose: those on a front), fastest first; " +
                       machines_of(results)) +
         bars_html(sweep, shown, "gpu.energy_nj.", "energy", "nJ",
                   "Energy of the chosen points by part (until you choose: those on a front), fastest first; " +
                       machines_of(results)) +
         "</div>\n";
  out += effects_table(results, shown, columns) + agreement_table(results) + unfinished_table(results) +
         earlier_table(results) + traces_table(results);
  const auto plan = results.meta.find("plan");
  if (plan != results.meta.end() && !plan->second.empty()) {
    out += details("The plan", "<pre>" + escape(plan->second) + "</pre>\n");
  }
  return out + "</section>\n";
}

}  // namespace grtx::view
