// SPDX-License-Identifier: Apache-2.0
// The section on a sweep: the explorer of its points, their table, effects of the coordinates.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "grtx/base/json.h"
#include "grtx/explore/sweep/axis.h"
#include "grtx/report/page/html.h"
#include "grtx/report/page/mode_agreement.h"
#include "grtx/report/page/sections.h"
#include "grtx/report/page/sweep_views.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;

/// The point's machine, design and coordinates in words: "paper, grtx, l1.bytes = 65536".
std::string words(const ReportedPoint& p) {
  std::string text = p.machine + (p.machine.empty() || p.design.empty() ? "" : ", ") + p.design;
  for (const auto& [name, value] : p.coordinates.items()) {
    text += (text.empty() ? "" : ", ") + name + " = " + explore::text_of(value);
  }
  return text;
}

/// Columns that distinguish the points of a view: machine and design if they vary, then the varying coordinates.
struct Describing {
  std::string title;
  std::function<ordered_json(const ReportedPoint&)> value;
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
  for (const std::size_t i : point.points) {
    for (const sim::ResultNote& note : results.points[i].notes) {
      if (std::find(ids.begin(), ids.end(), note.id) == ids.end()) ids.push_back(note.id);
    }
  }
  std::string text;
  for (const std::string& id : ids) text += (text.empty() ? "" : ", ") + id;
  return text;
}

struct Metric {
  const char* name;  ///< of a value in the database
  const char* title;
  const char* unit;  ///< "s", "J", "B": shown with a prefix; others as they are
  double scale;      ///< from the database's unit
  bool more;         ///< more is better
};
constexpr std::size_t kChipMetric = 1, kRtUnitMetric = 12;  ///< the page draws the second over the first
constexpr std::array<Metric, 13> kMetrics = {
    {{kTime, "time", "s", 1e-6, false},
     {kArea, "area", "mm²", 1.0, false},
     {kEnergy, "energy a ray", "J", 1e-9, false},
     {"gpu.cycles", "cycles", "", 1.0, false},
     {"gpu.rt.node_fetches", "node fetches", "", 1.0, false},
     {"gpu.rt.node_fetch_latency", "latency of a fetch, cycles", "", 1.0, false},
     {"gpu.l1.node.hit_rate", "L1 hit rate of nodes", "%", 100.0, true},
     {"gpu.l2.hit_rate", "L2 hit rate", "%", 100.0, true},
     {"gpu.l2.accesses", "L2 accesses", "", 1.0, false},
     {"gpu.dram.bytes", "DRAM bytes", "B", 1.0, false},
     {"gpu.dram.bandwidth_utilisation", "DRAM bandwidth used", "%", 100.0, true},
     {"gpu.bound.fraction", "largest bound, of the cycles", "%", 100.0, true},
     {explore::kRtUnitArea, "area of an RT unit", "mm²", 1.0, false}}};

/// With the area that the front is over in the second place.
std::array<Metric, 13> metrics_of(const SweepResults& results) {
  std::array<Metric, 13> metrics = kMetrics;
  if (results.area() != kArea) std::swap(metrics[kChipMetric], metrics[kRtUnitMetric]);
  return metrics;
}

/// Names directly below a prefix that any finished point has: parts of a stacked bar.
std::vector<std::string> parts_below(const SweepResults& results, const std::string& prefix) {
  std::vector<std::string> parts;
  for (const ReportedPoint& p : results.points) {
    for (auto it = p.values.lower_bound(prefix); it != p.values.end() && it->first.starts_with(prefix); ++it) {
      const std::string part = it->first.substr(prefix.size());
      if (part.find('.') != std::string::npos) continue;
      if (std::find(parts.begin(), parts.end(), part) == parts.end()) parts.push_back(part);
    }
  }
  return parts;
}

ordered_json sums_below(const SweepViews& shown, const ShownPoint& point, const std::string& prefix,
                        const std::vector<std::string>& parts) {
  ordered_json sums = ordered_json::array();
  for (const std::string& part : parts) sums.push_back(shown.sum(point, prefix + part));
  return sums;
}

/// A value of few digits: a page of 1,000 points stays small.
ordered_json rounded(double value) {
  return std::isfinite(value) ? ordered_json(std::stod(fmt::format("{:.6g}", value))) : ordered_json();
}

ordered_json explored_point(const ReportSweep& sweep, const SweepViews& shown, const ShownPoint& point,
                            const std::vector<Describing>& columns) {
  const ReportedPoint& p = shown.first(point);
  ordered_json row = {{"id", point.id},     {"label", point.label},  {"name", shown.name(p)},
                      {"view", point.view}, {"keys", point.setting}, {"machine", point.machine},
                      {"base", p.machine},  {"design", p.design}};
  ordered_json fields = ordered_json::array(), metrics = ordered_json::array();
  for (const Describing& column : columns) {
    const ordered_json value = column.value(p);
    fields.push_back(value.is_structured() ? ordered_json(json_text(value)) : value);
  }
  for (const Metric& metric : metrics_of(sweep.results))
    metrics.push_back(rounded(metric.scale * shown.value(point, metric.name)));
  row["fields"] = std::move(fields);
  row["metrics"] = std::move(metrics);
  if (const auto interval = shown.time_interval(point)) row["interval"] = {interval->low * 1e-6, interval->high * 1e-6};
  if (const std::string notes = note_ids(sweep.results, point); !notes.empty()) row["notes"] = notes;
  return row;
}

/// The data that web/explore.js draws.
std::string explorer_html(const ReportSweep& sweep, const SweepViews& shown, const std::vector<Describing>& columns) {
  ordered_json data;
  data["subject"] = machines_of(sweep.results);
  for (const SweepView& view : shown.views()) data["views"].push_back(view.title);
  data["designs"] = ordered_json::array();
  for (const ReportedPoint& p : sweep.results.points) {
    const bool known = std::find(data["designs"].begin(), data["designs"].end(), p.design) != data["designs"].end();
    if (p.done() && !known) data["designs"].push_back(p.design);
  }
  data["fields"] = ordered_json::array();
  for (const Describing& column : columns) data["fields"].push_back(column.title);
  for (const Metric& metric : metrics_of(sweep.results)) {
    data["metrics"].push_back({{"title", metric.title}, {"unit", metric.unit}, {"more", metric.more}});
  }
  const std::vector<std::string> stalls = parts_below(sweep.results, "gpu.rt.stall.");
  const std::vector<std::string> energy = parts_below(sweep.results, "gpu.energy_nj.");
  data["stalls"] = stalls;
  if (!stalls.empty()) data["stalls"].insert(data["stalls"].begin(), "issue");
  data["energy"] = energy;
  data["points"] = ordered_json::array();
  for (const ShownPoint& point : shown.points()) {
    ordered_json row = explored_point(sweep, shown, point, columns);
    row["stalls"] = sums_below(shown, point, "gpu.rt.stall.", stalls);
    if (!stalls.empty()) row["stalls"].insert(row["stalls"].begin(), shown.sum(point, "gpu.rt.selections"));
    row["energy"] = sums_below(shown, point, "gpu.energy_nj.", energy);
    for (ordered_json& nanojoules : row["energy"]) nanojoules = rounded(1e-9 * nanojoules.get<double>());
    data["points"].push_back(std::move(row));
  }
  return explorer(sweep.id, data, sweep.id + "_points");
}

/// Columns of the table: results first, then the point's coordinates.
std::string points_table(const ReportSweep& sweep, const SweepViews& shown, const std::vector<Describing>& columns) {
  const bool several = shown.views().size() > 1;
  std::vector<Table::Column> titles = {{"point"}};
  if (several) titles.push_back({"view", false});
  for (const char* title : {"time, µs", "speed-up", "chip, mm²", "RT unit, mm²", "nJ per ray"})
    titles.push_back({title});
  titles.push_back({"on the front of", false});
  for (const char* title : {"cycles", "L1 hit rate of nodes", "DRAM MB", "chip, mm², low – high"})
    titles.push_back({title});
  for (const Describing& column : columns) titles.push_back({column.title});
  const auto noted = [&](const ShownPoint& point) { return !note_ids(sweep.results, point).empty(); };
  const bool any_notes = std::any_of(shown.points().begin(), shown.points().end(), noted);
  if (any_notes) titles.push_back({"mind", false});
  Table table(sweep.results.file + ": finished points, " + machines_of(sweep.results), titles, sweep.id + "_points");
  const SpeedupOver reference = shown.reference();
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
    cells.push_back(number(value(explore::kRtUnitArea)));
    cells.push_back(number(value(kEnergy)));
    cells.push_back(point.on_area ? (point.on_energy ? "mm², nJ" : "mm²") : point.on_energy ? "nJ" : "");
    cells.push_back(number(value("gpu.cycles")));
    const double hits = value("gpu.l1.node.hit_rate");
    cells.push_back(std::isfinite(hits) ? fmt::format("{:.1f} %", 100.0 * hits) : "");
    cells.push_back(number(value("gpu.dram.bytes") * 1e-6));
    const double low = value("cost.mm2_low"), high = value("cost.mm2_high");
    cells.push_back(std::isfinite(low) && std::isfinite(high) ? number(low) + " – " + number(high) : "");
    for (const Describing& column : columns) cells.push_back(cell(column.value(p)));
    if (any_notes) cells.push_back(escape(note_ids(sweep.results, point)));
    table.row(cells, fmt::format(" data-id=\"{}\"{}", point.id, point.on_front() ? " class=\"front\"" : ""));
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
  const std::string view = shown.views().size() > 1 ? shown.views().front().title + ", " : "";
  Table table(results.file + ": what each value does, " + view + machines_of(results),
              {{"machine and design", false},
               {"coordinate", false},
               {"value"},
               {"points"},
               {"least time, µs"},
               {"median time, µs"},
               {"median mm² of " + owner_of(results.area())},
               {"median nJ per ray"}});
  std::map<std::pair<std::string, std::string>, std::vector<const ShownPoint*>> alike;  // by machine and design
  for (const ShownPoint& point : shown.points()) {
    if (point.view == 0) alike[{shown.first(point).machine, shown.first(point).design}].push_back(&point);
  }
  for (const auto& [own, points] : alike) {
    const std::string name = own.first + (own.first.empty() ? "" : ", ") + own.second;
    for (const Describing& column : columns) {
      std::map<ordered_json, std::vector<const ShownPoint*>> by_value;
      for (const ShownPoint* point : points) by_value[column.value(shown.first(*point))].push_back(point);
      if (by_value.size() < 2) continue;
      for (const auto& [value, having] : by_value) {
        std::vector<double> time, area, energy;
        for (const ShownPoint* point : having) {
          time.push_back(shown.value(*point, kTime));
          area.push_back(shown.area(*point));
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

}  // namespace

std::string sweep_section(const ReportSweep& sweep) {
  const SweepResults& results = sweep.results;
  const SweepViews shown(results);
  const std::vector<Describing> columns = describing(results, shown);
  std::string out = fmt::format("<section id=\"{}\" class=\"sweep\"><h2>Sweep {}</h2>\n{}", sweep.id,
                                escape(results.file), subject_html(results, sweep.id));
  if (shown.views().size() > 1) {
    out += shown.views().front().is_mean()
               ? "<p>Points are compared within a view of a scene. \"All views\" has geometric means, of hit rates and "
                 "other shares arithmetic ones, of the points that were simulated in each of them.</p>\n"
               : "<p>Points are compared within a view of a scene. No point was simulated in all of them, so there is "
                 "no mean.</p>\n";
  }
  if (!shown.points().empty()) out += explorer_html(sweep, shown, columns);
  out += points_table(sweep, shown, columns);
  out += effects_table(results, shown, columns) + agreement_table(results) + unfinished_table(results) +
         earlier_table(results) + traces_table(results);
  const auto plan = results.meta.find("plan");
  if (plan != results.meta.end() && !plan->second.empty()) {
    out += details("The plan", "<pre>" + escape(plan->second) + "</pre>\n");
  }
  return out + "</section>\n";
}

}  // namespace grtx::report
