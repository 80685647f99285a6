// SPDX-License-Identifier: Apache-2.0
// Sections on runs: headline, table of designs, stalls, energy, the paper's figures.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "grtx/modules/messages/memory_request.h"
#include "grtx/view/report/charts.h"
#include "grtx/view/report/html.h"
#include "grtx/view/report/paper_targets.h"
#include "grtx/view/report/sections.h"

namespace grtx::view {
namespace {

using nlohmann::ordered_json;

struct Part {
  std::string name;
  double value = 0.0;
};
struct Bar {
  std::string label;
  std::vector<Part> parts;
};

double energy_nj(const DesignResult& design, const MachineFigures& machine) {
  if (const double recorded = design.value("gpu.energy_nj"); std::isfinite(recorded)) return recorded;
  if (machine.energy.empty()) return std::numeric_limits<double>::quiet_NaN();
  double sum = 0.0;
  for (const ordered_json& part : machine.energy) sum += part.at("nanojoules").at("central").get<double>();
  return sum;
}

std::vector<Part> parts_below(const DesignResult& design, const std::string& prefix) {
  std::vector<Part> parts;
  for (const auto& [name, entry] : design.statistics.items()) {
    if (name.starts_with(prefix) && name.find('.', prefix.size()) == std::string::npos) {
      parts.push_back({name.substr(prefix.size()), design.value(name)});
    }
  }
  return parts;
}

std::vector<Part> stalls_of(const DesignResult& design) {
  std::vector<Part> parts = parts_below(design, "gpu.rt.stall.");
  if (!parts.empty()) parts.insert(parts.begin(), {"issue", design.value("gpu.rt.selections")});
  return parts;
}

std::vector<Part> energy_of(const DesignResult& design, const MachineFigures& machine) {
  std::vector<Part> parts = parts_below(design, "gpu.energy_nj.");
  if (!parts.empty()) return parts;
  for (const ordered_json& part : machine.energy) {
    parts.push_back({part.at("name").get<std::string>(), part.at("nanojoules").at("central").get<double>()});
  }
  return parts;
}

/// Traffic of a memory level by address region: `scale` times the sum of the region's counters.
std::vector<Part> regions_of(const DesignResult& design, const std::string& prefix,
                             const std::vector<std::string>& counters, double scale) {
  std::vector<Part> parts;
  for (const std::string& name : names_of<modules::Region>()) {
    double sum = 0.0;
    for (const std::string& counter : counters) {
      const double value = design.value(fmt::format(fmt::runtime(prefix + counter), name));
      if (std::isfinite(value)) sum += value;  // a region without accesses has no counter
    }
    if (sum > 0.0) parts.push_back({std::string(name), scale * sum});
  }
  return parts;
}

/// All parts in order of appearance; with more than `most`, the smallest become "other".
std::vector<std::string> join_small_parts(std::vector<Bar>& bars, std::size_t most) {
  std::vector<Part> sums;
  for (const Bar& bar : bars) {
    for (const Part& part : bar.parts) {
      const auto known = std::find_if(sums.begin(), sums.end(), [&](const Part& s) { return s.name == part.name; });
      if (known == sums.end()) {
        sums.push_back(part);
      } else {
        known->value += part.value;
      }
    }
  }
  std::erase_if(sums, [](const Part& s) { return !(s.value > 0.0); });
  std::vector<std::string> names;
  if (sums.size() <= most) {
    for (const Part& s : sums) names.push_back(s.name);
    return names;
  }
  std::vector<double> sizes;
  for (const Part& s : sums) sizes.push_back(s.value);
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(most) - 1, sizes.end(), std::greater<>());
  const double least = sizes[most - 1];
  for (const Part& s : sums) {
    if (s.value > least) names.push_back(s.name);
  }
  names.push_back("other");
  for (Bar& bar : bars) {
    std::vector<Part> kept;
    Part other{"other", 0.0};
    for (const Part& part : bar.parts) {
      if (std::find(names.begin(), names.end(), part.name) != names.end()) {
        kept.push_back(part);
      } else {
        other.value += part.value;
      }
    }
    kept.push_back(other);
    bar.parts = std::move(kept);
  }
  return names;
}

std::string bars_html(const std::string& id, std::vector<Bar> bars, const std::string& value_title,
                      const std::string& part_title, const std::string& caption) {
  std::erase_if(bars, [](const Bar& bar) { return bar.parts.empty(); });
  if (bars.empty()) return "";
  const std::vector<std::string> names = join_small_parts(bars, 11);
  ordered_json rows = ordered_json::array();
  std::vector<Table::Column> columns = {{part_title, false}};
  for (std::size_t b = 0; b < bars.size(); ++b) columns.push_back({bars[b].label});
  Table table(caption, columns);
  std::vector<double> sums(bars.size(), 0.0);
  for (std::size_t b = 0; b < bars.size(); ++b) {
    for (const Part& part : bars[b].parts) sums[b] += part.value;
    for (const Part& part : bars[b].parts) {
      if (!(part.value > 0.0)) continue;
      rows.push_back({{"id", b},
                      {"label", bars[b].label},
                      {"order", b},
                      {"part", part.name},
                      {"value", part.value},
                      {"share", part.value / sums[b]}});
    }
  }
  const auto value_cell = [&](std::size_t b, double value) {
    return fmt::format("{} <span class=\"share\">{:.1f} %</span>", number(value < 100.0 ? value : std::round(value)),
                       100.0 * value / sums[b]);
  };
  for (const std::string& name : names) {
    std::vector<std::string> cells = {escape(name)};
    for (std::size_t b = 0; b < bars.size(); ++b) {
      const auto part =
          std::find_if(bars[b].parts.begin(), bars[b].parts.end(), [&](const Part& p) { return p.name == name; });
      cells.push_back(part == bars[b].parts.end() ? "" : value_cell(b, part->value));
    }
    table.row(cells);
  }
  std::vector<std::string> cells = {"sum"};
  for (const double sum : sums) cells.push_back(number(sum < 100.0 ? sum : std::round(sum)));
  table.row(cells, " class=\"sum\"");
  return chart(id, caption, caption, stacked_bars(rows, names, value_title, part_title, false)) +
         details("The same as a table", table.html());
}

std::string designs_table(const ReportRun& run) {
  Table table(run.results.label + ": the designs", {{"design", false},
                                                    {"cycles"},
                                                    {"speed-up"},
                                                    {"node visits"},
                                                    {"node fetches"},
                                                    {"fetch latency, cycles"},
                                                    {"L1 hit rate"},
                                                    {"L2 accesses"},
                                                    {"DRAM MB"},
                                                    {"energy, µJ"},
                                                    {"largest bound", false}});
  const DesignResult* reference = run.results.design(run.results.speedup_over);
  for (std::size_t i = 0; i < run.results.designs.size(); ++i) {
    const DesignResult& d = run.results.designs[i];
    const double bound = d.value("gpu.bound.fraction"), hits = d.value("gpu.l1.node.hit_rate");
    table.row({escape(d.name), number(d.value("gpu.cycles")) + interval_html(d.cycles_interval(), number),
               reference == nullptr ? ""
                                    : times(reference->value("gpu.cycles") / d.value("gpu.cycles")) +
                                          interval_html(run.results.speedup_interval(d), times),
               number(d.value("gpu.rt.node_visits")), number(d.value("gpu.rt.node_fetches")),
               number(d.value("gpu.rt.node_fetch_latency")),
               std::isfinite(hits) ? fmt::format("{:.1f} %", 100.0 * hits) : "", number(d.value("gpu.l2.accesses")),
               number(d.value("gpu.dram.bytes") * 1e-6), number(energy_nj(d, run.machines[i]) * 1e-3),
               escape(d.binding_bound) + (std::isfinite(bound) ? fmt::format(" {:.0f} %", 100.0 * bound) : "")});
  }
  return table.html();
}

std::string all_statistics(const ReportRun& run) {
  std::vector<Table::Column> columns = {{"statistic", false}};
  for (const DesignResult& d : run.results.designs) columns.push_back({d.name});
  columns.push_back({"unit", false});
  columns.push_back({"description", false});
  Table table(run.results.label + ": all statistics", columns);
  std::vector<std::string> names;
  for (const DesignResult& d : run.results.designs) {
    for (const auto& [name, entry] : d.statistics.items()) {
      if (&d == &run.results.designs.front() || !run.results.designs.front().statistics.contains(name)) {
        if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
      }
    }
  }
  for (const std::string& name : names) {
    std::vector<std::string> cells = {escape(name)};
    ordered_json unit = "", description = "";
    for (const DesignResult& d : run.results.designs) {
      const auto entry = d.statistics.find(name);
      cells.push_back(entry == d.statistics.end() ? "" : cell(entry->at("value")));
      if (entry == d.statistics.end()) continue;
      unit = entry->value("unit", ordered_json(""));
      description = entry->value("description", ordered_json(""));
    }
    cells.push_back(cell(unit));
    cells.push_back(cell(description));
    table.row(cells);
  }
  return details("All statistics", table.html());
}

std::string over_time(const ReportRun& run, std::size_t index) {
  const ordered_json& series = run.results.over_time;
  if (!series.is_object() || !series.contains("end_of_interval")) return "";
  std::string out;
  for (const auto& [name, entry] : series.items()) {
    if (name == "end_of_interval" || !entry.is_object()) continue;
    const ordered_json& cycles = series.at("end_of_interval").at("values");
    const ordered_json& values = entry.at("values");
    ordered_json rows = ordered_json::array();
    for (std::size_t i = 0; i < std::min(cycles.size(), values.size()); ++i) {
      rows.push_back({{"cycle", cycles[i]}, {"series", name}, {"value", values[i]}});
    }
    const std::string caption =
        run.results.label + ": " + entry.value("description", name) + ", " + entry.value("unit", "");
    out += chart(fmt::format("time{}_{}", index, out.size()), caption, caption,
                 series_lines(rows, entry.value("unit", "")));
  }
  return out;
}

}  // namespace

std::string headline(const std::string& value_html, const std::string& what, const std::string& note) {
  return fmt::format("<div class=\"card\"><dt>{}</dt><dd>{}</dd>{}</div>\n", escape(what), value_html,
                     note.empty() ? "" : "<dd class=\"note\">" + escape(note) + "</dd>");
}

std::string picture(const std::string& uri, const std::string& caption) {
  return fmt::format("<figure class=\"picture\"><img src=\"{}\" alt=\"{}\"><figcaption>{}</figcaption></figure>\n", uri,
                     escape(caption), escape(caption));
}

std::string run_headline(const ReportRun& run) {
  std::string cards;
  for (const RunTarget& target : run_targets()) {
    if (target.statistic != "gpu.cycles") continue;
    const double own = target.of_run(run.results);
    if (!std::isfinite(own)) continue;
    cards += headline(times(own) + interval_html(interval_of(target, run.results), times), target.name,
                      "paper: " + times(target.paper) + " (mean)");
  }
  if (cards.empty()) {
    for (const DesignResult& d : run.results.designs) {
      cards += headline(number(d.value("gpu.cycles")) + interval_html(d.cycles_interval(), number), "Cycles, " + d.name,
                        fmt::format("{:.1f} µs", d.value("gpu.time_us")));
    }
  }
  const DesignResult& first = run.results.designs.front();  // all trace the same rays
  if (const double share = first.value("tracer.ert_share"); std::isfinite(share)) {
    cards += headline(fmt::format("{:.1f} %", 100.0 * share), "Rays ended early", "by transmittance");
  }
  if (const double behind = first.value("tracer.hits_behind_end"); std::isfinite(behind)) {
    cards += headline(times(behind), "Hits behind the end", "hits of rays / hits that they process");
  }
  if (run.results.has_verdict) {
    cards += headline(run.results.images_identical ? "yes" : "<strong>NO</strong>", "Images identical",
                      "of all designs, bit for bit");
    cards += headline(number(static_cast<double>(run.results.violations.size())), "Violated laws",
                      "conservation checks of the hardware model");
  }
  return fmt::format("<h3>{}</h3>\n{}{}<dl class=\"cards\">\n{}</dl>\n", escape(run.title()), subject_html(run),
                     run_verdict(run), cards);
}

std::string run_section(const ReportRun& run, std::size_t index) {
  std::string out =
      fmt::format("<section id=\"run{}\"><h2>Run: {}</h2>\n{}", index, escape(run.title()), subject_html(run));
  out += designs_table(run) + bytes_table(run);
  for (const std::string& violation : run.results.violations) {
    out += "<p class=\"bad\">Violated: " + escape(violation) + "</p>\n";
  }
  if (!run.results.picture.empty()) {
    out += picture(picture_uri(run.results.picture), run.results.label + ": the picture as simulated");
  } else if (!run.results.picture_problem.empty()) {
    out += "<p class=\"note\">No picture: " + escape(run.results.picture_problem) + ".</p>\n";
  }
  out += over_time(run, index);
  return out + all_statistics(run) + "</section>\n";
}

std::string bars_section(const std::vector<ReportRun>& runs) {
  std::vector<Bar> stalls, energy, l2, dram;
  for (const ReportRun& run : runs) {
    for (std::size_t i = 0; i < run.results.designs.size(); ++i) {
      stalls.push_back({run.bar_label(i), stalls_of(run.results.designs[i])});
      energy.push_back({run.bar_label(i), energy_of(run.results.designs[i], run.machines[i])});
      l2.push_back({run.bar_label(i), regions_of(run.results.designs[i], "gpu.l2.", {"{}.reads", "{}.writes"}, 1.0)});
      dram.push_back(
          {run.bar_label(i), regions_of(run.results.designs[i], "gpu.l2.", {"dram_reads.{}", "dram_writes.{}"},
                                        static_cast<double>(modules::kSectorBytes) * 1e-6)});
    }
  }
  const std::string machines = machines_of(runs), of = machines.empty() ? "" : "; " + machines;
  return "<section id=\"bars\"><h2>Where cycles, traffic and energy went</h2>\n" + subjects_html(runs) +
         bars_html("stalls", stalls, "cycles of all RT units", "cycles",
                   "Cycles of the RT units: a warp was scheduled (issue), or why none was" + of) +
         bars_html("l2", l2, "accesses", "region", "Accesses of the L2, sectors of 32 B, by what they were for" + of) +
         bars_html("dram", dram, "MB", "region",
                   "Bytes read from DRAM and written to it, MB, by what they were for" + of) +
         bars_html("energy", energy, "nJ", "part",
                   "Energy of the run by part, nJ, central estimate, process node of grtx cost" + of) +
         "</section>\n";
}

}  // namespace grtx::view
