// Sections on sweeps: Pareto fronts, table of points, stalls and energy of chosen points, effects of the coordinates.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "grtx/explore/report/charts.h"
#include "grtx/explore/report/html.h"
#include "grtx/explore/report/mode_agreement.h"
#include "grtx/explore/report/pareto.h"
#include "grtx/explore/report/sections.h"
#include "grtx/explore/sweep/axis.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;

// Values of a sweep's points, as `grtx sweep` names them.
constexpr const char* kTime = "gpu.time_us";
constexpr const char* kArea = "cost.mm2";
constexpr const char* kEnergy = "gpu.energy_nj_per_ray";

/// Points that compare with each other: their fronts are drawn apart.
std::string group_of(const ReportedPoint& p) { return p.scene + "\n" + p.mode; }

/// The point's coordinates in words: "l1.bytes = 65536, k = 8".
std::string words(const ReportedPoint& p) {
  std::string text = p.design;
  for (const auto& [name, value] : p.coordinates.items()) {
    text += (text.empty() ? "" : ", ") + name + " = " + text_of(value);
  }
  return text;
}

/// Cycles of the baseline at the same scene, mode and coordinates over the point's; NaN without one.
std::vector<double> speedups(const SweepResults& sweep) {
  const auto place = [](const ReportedPoint& p) { return group_of(p) + "\n" + p.coordinates.dump(); };
  std::map<std::string, double> baseline;
  for (const ReportedPoint& p : sweep.points) {
    if (p.done() && p.design == "baseline") baseline[place(p)] = p.value("gpu.cycles");
  }
  std::vector<double> list;
  for (const ReportedPoint& p : sweep.points) {
    const auto found = baseline.find(place(p));
    list.push_back(p.done() && found != baseline.end() ? found->second / p.value("gpu.cycles")
                                                       : std::numeric_limits<double>::quiet_NaN());
  }
  return list;
}

/// Columns that tell the points apart: scene, design and mode when they vary, then the coordinates.
struct Describing {
  std::string title;
  std::function<ordered_json(const ReportedPoint&)> of;
};
std::vector<Describing> describing(const SweepResults& sweep) {
  std::vector<Describing> list;
  const auto has = [&](const char* name) {
    return std::find(sweep.coordinates.begin(), sweep.coordinates.end(), name) != sweep.coordinates.end();
  };
  if (sweep.several(&ReportedPoint::scene) && !has("scene")) {
    list.push_back({"scene", [](const ReportedPoint& p) { return ordered_json(p.scene); }});
  }
  if (sweep.several(&ReportedPoint::design) && !has("design")) {
    list.push_back({"design", [](const ReportedPoint& p) { return ordered_json(p.design); }});
  }
  if (sweep.several(&ReportedPoint::mode) && !has("mode")) {
    list.push_back({"mode", [](const ReportedPoint& p) { return ordered_json(p.mode); }});
  }
  for (const std::string& name : sweep.coordinates) {
    list.push_back({name, [name](const ReportedPoint& p) {
                      return p.coordinates.contains(name) ? p.coordinates.at(name) : ordered_json();
                    }});
  }
  return list;
}

std::string pareto_html(const ReportSweep& sweep, const std::vector<Describing>& columns, const ChartField& cost,
                        const std::vector<bool>& on_front, const std::string& what) {
  ordered_json rows = ordered_json::array();
  std::vector<ChartField> tooltip = {{"label", "point"}};
  std::size_t without = 0;
  for (std::size_t i = 0; i < sweep.results.points.size(); ++i) {
    const ReportedPoint& p = sweep.results.points[i];
    if (!p.done()) continue;
    if (!std::isfinite(p.value(kTime)) || !std::isfinite(p.value(cost.field))) {
      ++without;
      continue;
    }
    ordered_json row = {{"id", p.id},
                        {"label", fmt::format("#{}", p.id)},
                        {"time", p.value(kTime)},
                        {"cost", p.value(cost.field)},
                        {"front", static_cast<bool>(on_front[i])},
                        {"group", group_of(p)},
                        {"none", "all points"}};
    // Names of coordinates hold dots, which Vega-Lite would read as paths: numbered fields carry them.
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const ordered_json value = columns[c].of(p);
      row[fmt::format("c{}", c)] = value.is_structured() ? ordered_json(value.dump()) : value;
    }
    rows.push_back(std::move(row));
  }
  if (rows.empty()) return "";
  for (std::size_t c = 0; c < columns.size(); ++c) tooltip.push_back({fmt::format("c{}", c), columns[c].title});
  tooltip.push_back({"time", "time, µs", true});
  tooltip.push_back({"cost", cost.title, true});
  std::string caption = fmt::format(
      "{} against simulated time: {} points, {} on the front (large, dashed line). Hover for the configuration; drag a "
      "box to choose points, double-click to choose all.",
      what, rows.size(), std::count(on_front.begin(), on_front.end(), true));
  if (without != 0) caption += fmt::format(" {} points have no such figure.", without);
  return chart(sweep.id + "_" + (cost.field == kArea ? "area" : "energy"), what + " against time, one mark a point",
               caption,
               pareto_chart(rows, {"time", "time, µs"}, {"cost", cost.title}, tooltip, columns.empty() ? "none" : "c0"),
               "pareto", sweep.id);
}

std::string bars_html(const ReportSweep& sweep, const Fronts& front, const std::string& prefix, const std::string& id,
                      const std::string& value_title, const std::string& caption) {
  ordered_json rows = ordered_json::array();
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < sweep.results.points.size(); ++i) {
    const ReportedPoint& p = sweep.results.points[i];
    if (!p.done()) continue;
    std::vector<std::pair<std::string, double>> own;
    if (prefix == "gpu.rt.stall.") own.emplace_back("issue", p.value("gpu.rt.selections"));
    for (auto it = p.values.lower_bound(prefix); it != p.values.end() && it->first.starts_with(prefix); ++it) {
      if (it->first.find('.', prefix.size()) == std::string::npos) {
        own.emplace_back(it->first.substr(prefix.size()), it->second);
      }
    }
    double sum = 0.0;
    for (const auto& [part, value] : own) sum += std::isfinite(value) ? value : 0.0;
    for (const auto& [part, value] : own) {
      if (!(value > 0.0)) continue;
      if (std::find(parts.begin(), parts.end(), part) == parts.end()) parts.push_back(part);
      rows.push_back({{"id", p.id},
                      {"label", fmt::format("#{}", p.id)},
                      {"order", p.value(kTime)},
                      {"front", front.any(i)},
                      {"part", part},
                      {"value", value},
                      {"share", value / sum}});
    }
  }
  if (rows.empty()) return "";
  return chart(sweep.id + "_" + id + "_bars", caption, caption, stacked_bars(rows, parts, value_title, "part", true),
               "bars", sweep.id);
}

std::string points_table(const ReportSweep& sweep, const Fronts& front, const std::vector<Describing>& columns) {
  const SweepResults& results = sweep.results;
  const std::vector<double> ratios = speedups(results);
  const bool has_ratio = std::any_of(ratios.begin(), ratios.end(), [](double r) { return std::isfinite(r); });
  std::vector<Table::Column> titles = {{"point"}};
  for (const Describing& column : columns) titles.push_back({column.title});
  for (const char* title : {"time, µs", "cycles"}) titles.push_back({title});
  if (has_ratio) titles.push_back({"speed-up"});
  for (const char* title : {"mm²", "low – high", "nJ a ray", "L1 hit rate", "DRAM MB"}) titles.push_back({title});
  titles.push_back({"on the front of", false});
  Table table(results.file + ": finished points", titles, sweep.id + "_points");
  for (std::size_t i = 0; i < results.points.size(); ++i) {
    const ReportedPoint& p = results.points[i];
    if (!p.done()) continue;
    std::vector<std::string> cells = {fmt::format("#{}", p.id)};
    for (const Describing& column : columns) cells.push_back(cell(column.of(p)));
    cells.push_back(number(p.value(kTime)));
    cells.push_back(number(p.value("gpu.cycles")));
    if (has_ratio) cells.push_back(times(ratios[i]));
    cells.push_back(number(p.value(kArea)));
    const double low = p.value("cost.mm2_low"), high = p.value("cost.mm2_high");
    cells.push_back(std::isfinite(low) && std::isfinite(high) ? number(low) + " – " + number(high) : "");
    cells.push_back(number(p.value(kEnergy)));
    const double hits = p.value("gpu.l1.node.hit_rate");
    cells.push_back(std::isfinite(hits) ? fmt::format("{:.1f} %", 100.0 * hits) : "");
    cells.push_back(number(p.value("gpu.dram.bytes") * 1e-6));
    cells.push_back(front.area[i] ? (front.energy[i] ? "mm², nJ" : "mm²") : front.energy[i] ? "nJ" : "");
    table.row(cells, fmt::format(" data-id=\"{}\"{}", p.id, front.any(i) ? " class=\"front\"" : ""));
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

/// For each value of each coordinate, the points that have it.
std::string effects_table(const SweepResults& results, const std::vector<Describing>& columns) {
  Table table(results.file + ": what each value does", {{"coordinate", false},
                                                        {"value"},
                                                        {"points"},
                                                        {"least time, µs"},
                                                        {"median time, µs"},
                                                        {"median mm²"},
                                                        {"median nJ a ray"}});
  for (const Describing& column : columns) {
    std::vector<ordered_json> values;
    for (const ReportedPoint& p : results.points) {
      if (const ordered_json v = column.of(p); p.done() && std::find(values.begin(), values.end(), v) == values.end()) {
        values.push_back(v);
      }
    }
    if (values.size() < 2) continue;
    std::sort(values.begin(), values.end());
    for (const ordered_json& value : values) {
      std::vector<double> time, area, energy;
      for (const ReportedPoint& p : results.points) {
        if (!p.done() || column.of(p) != value) continue;
        time.push_back(p.value(kTime));
        area.push_back(p.value(kArea));
        energy.push_back(p.value(kEnergy));
      }
      table.row({escape(column.title), cell(value), number(static_cast<double>(time.size())),
                 number(*std::min_element(time.begin(), time.end())), number(median(time)), number(median(area)),
                 number(median(energy))});
    }
  }
  return table.rows() == 0 ? "" : table.html();
}

std::string agreement_table(const SweepResults& results) {
  Table table(results.file + ": points that two modes have simulated", {{"scene", false},
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

std::string colour_choice(const ReportSweep& sweep, const std::vector<Describing>& columns) {
  std::string options;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    options += fmt::format("<option value=\"c{}\">{}</option>", c, escape(columns[c].title));
  }
  options += "<option value=\"none\">nothing</option>";
  return fmt::format(
      "<p class=\"controls\" data-group=\"{0}\" hidden><label>Colour by <select class=\"colour\">{1}</select></label> "
      "<button type=\"button\" class=\"all\">Choose all points</button> "
      "<span class=\"chosen\" role=\"status\"></span></p>\n",
      sweep.id, options);
}

}  // namespace

Fronts fronts(const SweepResults& sweep) {
  Fronts result{std::vector<bool>(sweep.points.size(), false), std::vector<bool>(sweep.points.size(), false)};
  std::map<std::string, std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < sweep.points.size(); ++i) {
    if (sweep.points[i].done()) groups[group_of(sweep.points[i])].push_back(i);
  }
  for (const auto& [name, members] : groups) {
    std::vector<Costs> area, energy;
    for (const std::size_t i : members) {
      area.push_back({sweep.points[i].value(kTime), sweep.points[i].value(kArea)});
      energy.push_back({sweep.points[i].value(kTime), sweep.points[i].value(kEnergy)});
    }
    const std::vector<bool> on_area = pareto_front(area), on_energy = pareto_front(energy);
    for (std::size_t m = 0; m < members.size(); ++m) {
      result.area[members[m]] = on_area[m];
      result.energy[members[m]] = on_energy[m];
    }
  }
  return result;
}

std::string sweep_headline(const ReportSweep& sweep) {
  const SweepResults& results = sweep.results;
  const Fronts front = fronts(results);
  std::map<std::string, std::size_t> states;
  const ReportedPoint* best[3] = {};
  const char* const values[3] = {kTime, kArea, kEnergy};
  for (const ReportedPoint& p : results.points) {
    ++states[p.status];
    for (unsigned i = 0; i < 3; ++i) {
      if (p.done() && std::isfinite(p.value(values[i])) &&
          (best[i] == nullptr || p.value(values[i]) < best[i]->value(values[i]))) {
        best[i] = &p;
      }
    }
  }
  std::string other;
  for (const auto& [status, count] : states) {
    if (status != "done") other += fmt::format("{}{} {}", other.empty() ? "" : ", ", count, status);
  }
  std::string cards = headline(fmt::format("{} / {}", states["done"], results.points.size()), "Points done", other);
  const char* const names[3] = {"Least time", "Least area", "Least energy a ray"};
  const char* const units[3] = {" µs", " mm²", " nJ"};
  for (unsigned i = 0; i < 3; ++i) {
    if (best[i] == nullptr) continue;
    cards += headline(number(best[i]->value(values[i])) + units[i], names[i],
                      fmt::format("#{}: {}", best[i]->id, words(*best[i])));
  }
  cards += headline(number(static_cast<double>(std::count(front.area.begin(), front.area.end(), true))),
                    "Points on the front", "of mm² against time");
  return fmt::format("<h3>{}</h3>\n<dl class=\"cards\">\n{}</dl>\n", escape(results.file), cards);
}

std::string sweep_section(const ReportSweep& sweep) {
  const SweepResults& results = sweep.results;
  const Fronts front = fronts(results);
  const std::vector<Describing> columns = describing(results);
  std::string out =
      fmt::format("<section id=\"{}\" class=\"sweep\"><h2>Sweep {}</h2>\n", sweep.id, escape(results.file));
  const std::string area = pareto_html(sweep, columns, {kArea, "mm²"}, front.area, "Area");
  const std::string energy = pareto_html(sweep, columns, {kEnergy, "nJ a ray"}, front.energy, "Energy of a ray");
  if (!area.empty() || !energy.empty()) out += colour_choice(sweep, columns);
  out += "<div class=\"pair\">" + area + energy + "</div>\n";
  out += points_table(sweep, front, columns);
  out += "<div class=\"pair\">" +
         bars_html(sweep, front, "gpu.rt.stall.", "stalls", "cycles of all RT units",
                   "Cycles of the RT units of the chosen points (until you choose: those on a front), fastest first") +
         bars_html(sweep, front, "gpu.energy_nj.", "energy", "nJ",
                   "Energy of the chosen points by part (until you choose: those on a front), fastest first") +
         "</div>\n";
  out += effects_table(results, columns) + agreement_table(results) + unfinished_table(results) + traces_table(results);
  const auto plan = results.meta.find("plan");
  if (plan != results.meta.end() && !plan->second.empty()) {
    out += details("The plan", "<pre>" + escape(plan->second) + "</pre>\n");
  }
  return out + "</section>\n";
}

}  // namespace grtx::sim
