// SPDX-License-Identifier: Apache-2.0
// Sections on runs: the table of designs, all statistics, stalls and energy.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "grtx/explore/sweep/designs.h"
#include "grtx/report/page/charts.h"
#include "grtx/report/page/html.h"
#include "grtx/report/page/part_bars.h"
#include "grtx/report/page/run_latency.h"
#include "grtx/report/page/run_traffic.h"
#include "grtx/report/page/sections.h"
#include "grtx/report/page/speedup_terms.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;

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
  const auto memory = std::ranges::find(parts, "memory", &Part::name);
  if (memory == parts.end()) return parts;
  std::vector<Part> levels = node_read_levels(design);
  for (Part& level : levels) level = {"memory: " + level.name, level.value * memory->value};
  if (!levels.empty()) parts.insert(parts.erase(memory), levels.begin(), levels.end());
  return parts;
}

/// In J.
std::vector<Part> energy_of(const DesignResult& design, const MachineFigures& machine) {
  std::vector<Part> parts = parts_below(design, "gpu.energy_nj.");
  for (Part& part : parts) part.value *= 1e-9;
  if (!parts.empty()) return parts;
  for (const ordered_json& part : machine.energy) {
    parts.push_back({part.at("name").get<std::string>(), 1e-9 * part.at("nanojoules").at("central").get<double>()});
  }
  return parts;
}

using Figure = std::function<std::string(std::size_t)>;  // cell of design i; "" where it has none

/// Rows of a table with one column per design; a figure that no design has gets none.
struct FigureRows {
  Table& table;
  const std::vector<DesignResult>& designs;

  void add(const std::string& name, const Figure& figure) {
    std::vector<std::string> cells = {escape(name)};
    bool any = false;
    for (std::size_t i = 0; i < designs.size(); ++i) {
      cells.push_back(figure(i));
      any = any || !cells.back().empty();
    }
    if (any) table.row(cells);
  }

  /// In one unit, so that designs compare at a glance.
  void add(const std::string& name, const std::string& unit, const std::function<double(std::size_t)>& value) {
    std::vector<double> values;
    for (std::size_t i = 0; i < designs.size(); ++i) values.push_back(value(i));
    const std::vector<std::string> texts = in_one_unit(values, unit);
    add(name, [&texts](std::size_t i) { return texts[i]; });
  }
};

void add_times(FigureRows& rows, const ReportRun& run) {
  const std::vector<DesignResult>& designs = run.results.designs;
  const auto seconds = [&](std::size_t i) { return designs[i].frame_seconds(); };
  const auto rays = [&](std::size_t i) {
    return designs[i].value("tracer.rays") / static_cast<double>(designs[i].frames()) / seconds(i);
  };
  const auto mm2 = [&](std::size_t i) { return chip_mm2(run.machines[i]); };
  rows.add("time of " + frame_text(designs.front().frames()), "s", seconds);
  rows.add("of it traversal: warps in the RT units", "s",
           [&](std::size_t i) { return seconds(i) * traversal_share(designs[i]); });
  rows.add("of it shading: warps in shaders", "s",
           [&](std::size_t i) { return seconds(i) * (1.0 - traversal_share(designs[i])); });
  rows.add("rays a second", "rays/s", rays);
  rows.add("area, mm²", [&](std::size_t i) { return number(mm2(i)); });
  rows.add("rays a second per mm²", "rays/s", [&](std::size_t i) { return rays(i) / mm2(i); });
}

void add_reads(FigureRows& rows, const std::vector<DesignResult>& designs) {
  const auto statistic = [&](const char* name) {
    return [&designs, name](std::size_t i) { return number(designs[i].value(name)); };
  };
  rows.add("node visits", statistic("gpu.rt.node_visits"));
  rows.add("node fetches", statistic("gpu.rt.node_fetches"));
  rows.add("latency of a fetch, cycles", statistic("gpu.rt.node_fetch_latency"));
  rows.add("L1 hit rate of nodes", [&](std::size_t i) {
    const double hits = designs[i].value("gpu.l1.node.hit_rate");
    return std::isfinite(hits) ? fmt::format("{:.1f} %", 100.0 * hits) : std::string();
  });
  for (const auto& [level, name] : {std::pair(MemoryLevel::l2, "L2: "), std::pair(MemoryLevel::dram, "DRAM: ")}) {
    for (std::size_t purpose = 0; purpose < kPurposes; ++purpose) {
      rows.add(name + purpose_name(purpose), "B", [&, level = level](std::size_t i) {
        const double bytes = bytes_for(designs[i], level, purpose);
        return bytes > 0.0 ? bytes : std::nan("");
      });
    }
  }
}

/// One row per figure and one column per design, so that five designs fit; figures that no design has are absent.
std::string designs_table(const ReportRun& run) {
  const std::vector<DesignResult>& designs = run.results.designs;
  std::vector<Table::Column> columns = {{"figure", false}};
  for (const DesignResult& d : designs) columns.push_back({d.name});
  Table table(run.results.label + ": the designs", columns);
  FigureRows rows{table, designs};
  rows.add("speed-up", [&](std::size_t i) { return speedup_text(run, designs[i]); });
  const auto picture = [&designs](std::vector<double> PictureResult::*psnr) {
    return [&designs, psnr](std::size_t i) {
      return designs[i].picture ? decibels_text(*designs[i].picture.*psnr) : std::string();
    };
  };
  rows.add("picture against " + run.results.speedup_over, picture(&PictureResult::over));
  rows.add("picture against the reference in its own order", picture(&PictureResult::reference));
  rows.add("cycles", [&](std::size_t i) {
    return number(designs[i].value("gpu.cycles")) + interval_html(designs[i].cycles_interval(), number);
  });
  add_times(rows, run);
  rows.add("largest bound", [&](std::size_t i) {
    const std::string bound = binding_text(designs[i]);
    return bound.empty() ? bound : "<span class=\"words\">" + escape(bound) + "</span>";
  });
  add_reads(rows, designs);
  const std::size_t frames = designs.front().frames();
  rows.add(frames == 1 ? "energy" : "energy of " + frame_text(frames), "J", [&](std::size_t i) {
    return energy_nj(designs[i], run.machines[i]) * 1e-9 / static_cast<double>(designs[i].frames());
  });
  rows.add("energy a ray", "J", [&](std::size_t i) { return designs[i].value("gpu.energy_nj_per_ray") * 1e-9; });
  if (frames == 1) return table.html();
  return table.html() +
         fmt::format("<p class=\"note\">Cycles, visits, fetches and bytes are of all {} frames.</p>\n", frames);
}

/// What each of them is; "" of runs without designs.
std::string designs_note(const ReportRun& run) {
  std::string text;
  for (const DesignResult& d : run.results.designs) {
    const auto& known = explore::design_names();
    if (std::ranges::find(known, d.name) == known.end()) continue;
    text += fmt::format("{}<strong>{}</strong>: {}", text.empty() ? "" : "; ", escape(d.name),
                        escape(explore::design_of(d.name).says));
  }
  return text.empty() ? "" : "<p class=\"note\">" + text + ".</p>\n";
}

/// How the cycles of the design that speed-ups are over become those of the fastest, term by term.
std::string waterfall_chart(const std::string& label, const DesignResult& over, const DesignResult& best,
                            const std::vector<SpeedupTerm>& terms, const std::string& id) {
  ordered_json rows = ordered_json::array();
  const auto add = [&rows](const std::string& step, const char* change, double before, double after) {
    rows.push_back({{"label", step}, {"order", rows.size()}, {"change", change}, {"before", before}, {"after", after}});
  };
  double before = over.value("gpu.cycles");
  add(over.name, "whole", 0.0, before);
  for (const SpeedupTerm& term : terms) {
    add(std::string(term.name).substr(0, std::string(term.name).find(':')), term.factor >= 1.0 ? "gain" : "loss",
        before, term.cycles);
    before = term.cycles;
  }
  add(best.name, "whole", 0.0, before);
  const std::string caption = fmt::format(
      "{}: from the cycles of {} to those of {}, one term after the other; green saves cycles, red adds some", label,
      over.name, best.name);
  return chart("waterfall" + id, caption, caption, waterfall(rows, "cycles"));
}

/// What each term contributes to each design's speed-up, and to that of the fastest over the next.
std::string waterfall_html(const ReportRun& run, std::size_t index) {
  const DesignResult* over = run.results.design(run.results.speedup_over);
  if (over == nullptr) return "";
  const DesignResult& best = fastest(run.results);
  const DesignResult* next = next_to(best, run.results);
  std::vector<Table::Column> columns = {{"factor of the speed-up", false}};
  std::vector<std::vector<std::string>> rows;
  std::string charts;
  const auto add = [&](const DesignResult& from, const DesignResult& to, const std::string& title) {
    const std::vector<SpeedupTerm> terms = speedup_terms(from, to);
    if (terms.empty()) return;
    if (rows.empty()) {
      for (const SpeedupTerm& term : terms) rows.push_back({escape(term.name)});
      rows.push_back({"speed-up"});
    }
    columns.push_back({title});
    double all = 1.0;
    for (std::size_t i = 0; i < terms.size(); ++i) {
      rows[i].push_back(times(terms[i].factor));
      all *= terms[i].factor;
    }
    rows.back().push_back(times(all));
    if (&to != &best) return;
    charts += waterfall_chart(run.results.label, from, to, terms,
                              &from == over ? fmt::format("{}", index) : fmt::format("{}_next", index));
  };
  for (const DesignResult& design : run.results.designs) {
    if (&design != over) add(*over, design, design.name);
  }
  const bool with_next = next != nullptr && next != over && &best != over;
  if (with_next) add(*next, best, best.name + " over " + next->name);
  if (rows.empty()) return "";
  Table table(fmt::format("{}: speed-up over {}, the terms, whose product it is{}", run.results.label, over->name,
                          with_next ? "; in the last column over " + next->name + ", the next" : ""),
              columns);
  for (const std::vector<std::string>& row : rows) table.row(row);
  return "<div class=\"pair\">" + charts + "</div>\n" + table.html() +
         "<p class=\"note\">A factor is the mean over all orders in which the terms can be exchanged. Fetches under "
         "way and warps are the overlap. The residual is what waits of shaders do beside their number.</p>\n";
}

/// Of a sequence: speed-up and pictures of each frame.
std::string frames_table(const ReportRun& run) {
  const std::vector<DesignResult>& designs = run.results.designs;
  std::size_t frames = 0;
  std::vector<Table::Column> columns = {{"frame", false}};
  for (const DesignResult& d : designs) {
    frames = std::max(frames, d.frame_speedups.size());
    columns.push_back({d.name});
    columns.push_back({d.name + ": picture against " + run.results.speedup_over});
    columns.push_back({d.name + ": picture against the reference"});
  }
  if (frames == 0) return "";
  Table table(run.results.label + ": frame by frame", columns);
  const auto shown = [](const std::vector<double>& list, std::size_t frame) {
    return frame < list.size() ? decibels_text({list[frame]}) : std::string();
  };
  for (std::size_t frame = 0; frame < frames; ++frame) {
    std::vector<std::string> cells = {fmt::format("{}", frame)};
    for (const DesignResult& d : designs) {
      cells.push_back(frame < d.frame_speedups.size() ? times(d.frame_speedups[frame]) : "");
      cells.push_back(d.picture ? shown(d.picture->over, frame) : "");
      cells.push_back(d.picture ? shown(d.picture->reference, frame) : "");
    }
    table.row(cells);
  }
  return table.html();
}

/// Whether a design has the statistic, and it is not 0.
bool tells(const DesignResult& design, const std::string& name) {
  const auto entry = design.statistics.find(name);
  return entry != design.statistics.end() && entry->at("value") != 0;
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
  std::size_t zero = 0;
  for (const std::string& name : names) {
    const auto some = [&name](const DesignResult& d) { return tells(d, name); };
    if (std::none_of(run.results.designs.begin(), run.results.designs.end(), some)) {
      ++zero;  // of parts that none of the designs has, mostly
      continue;
    }
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
  return details("All statistics",
                 table.html() + fmt::format("<p class=\"note\">{} more are 0 in each design.</p>\n", zero));
}

/// Adds the course of a value of a design.
void add_course(ordered_json& rows, const DesignResult& design, const std::string& name) {
  const ordered_json& cycles = design.over_time.at("end_of_interval").at("values");
  const ordered_json& values = design.over_time.at(name).at("values");
  const double end = cycles.empty() || !cycles.back().is_number() ? 0.0 : cycles.back().get<double>();
  for (std::size_t i = 0; i < std::min(cycles.size(), values.size()); ++i) {
    const auto add = [&](const ordered_json& cycle) {
      const double part = end > 0.0 && cycle.is_number() ? cycle.get<double>() / end : 0.0;
      rows.push_back({{"cycle", cycle}, {"part", part}, {"series", design.name}, {"value", values[i]}});
    };
    if (i == 0) add(0);  // the first interval's begin
    add(cycles[i]);
  }
}

std::string over_time(const ReportRun& run, std::size_t index) {
  std::vector<std::string> designs;
  std::vector<std::string> names;  // of the first design's values, which all have
  for (const DesignResult& design : run.results.designs) {
    if (!design.over_time.is_object() || !design.over_time.contains("end_of_interval")) continue;
    designs.push_back(design.name);
    for (const auto& [name, entry] : design.over_time.items()) {
      if (designs.size() == 1 && name != "end_of_interval") names.push_back(name);
    }
  }
  std::string out;
  for (const std::string& name : names) {
    ordered_json rows = ordered_json::array(), entry;
    for (const DesignResult& design : run.results.designs) {
      if (!design.over_time.is_object() || !design.over_time.contains(name)) continue;
      if (entry.is_null()) entry = design.over_time.at(name);
      add_course(rows, design, name);
    }
    const std::string caption =
        run.results.label + ": " + entry.value("description", name) + ", " + entry.value("unit", "");
    out += chart(fmt::format("time{}_{}", index, out.size()), caption, caption,
                 series_lines(rows, entry.value("unit", ""), designs));
  }
  return out;
}

}  // namespace

double traversal_share(const DesignResult& design) {
  return (design.value("gpu.simt.warp_cycles.trace") + design.value("gpu.simt.warp_cycles.fetch")) /
         design.value("gpu.simt.resident_warp_cycles");
}

std::string run_section(const ReportRun& run, std::size_t index) {
  std::string out = fmt::format("<section id=\"run{}\"><h2>The run{}</h2>\n{}", index,
                                run.name.empty() ? "" : ": " + escape(run.name), subject_html(run));
  out += designs_table(run) + designs_note(run) + frames_table(run) + waterfall_html(run, index);
  for (const std::string& violation : run.results.violations) {
    out += "<p class=\"bad\">Violated: " + escape(violation) + "</p>\n";
  }
  out += read_latency_html(run.results.designs,
                           "Reads of 32 B: cycles from the requester's port and back, and where they are spent");
  out += over_time(run, index);
  return out + all_statistics(run) + "</section>\n";
}

std::string bars_section(const std::vector<ReportRun>& runs) {
  std::vector<Bar> stalls, energy;
  for (const ReportRun& run : runs) {
    for (std::size_t i = 0; i < run.results.designs.size(); ++i) {
      stalls.push_back({run.bar_label(i), stalls_of(run.results.designs[i])});
      energy.push_back({run.bar_label(i), energy_of(run.results.designs[i], run.machines[i])});
    }
  }
  const std::string machines = machines_of(runs), suffix = machines.empty() ? "" : "; " + machines;
  return "<section id=\"bars\"><h2>Where cycles and energy went</h2>\n" + subjects_html(runs) +
         bars_html({"stalls", "cycles of all RT units", "", "cycles",
                    "Cycles of the RT units: a warp was scheduled (issue), or why none was" + suffix},
                   stalls) +
         bars_html({"energy", "energy", "J", "part",
                    "Energy of the run by part, central estimate, process node of grtx cost" + suffix},
                   energy) +
         "</section>\n";
}

}  // namespace grtx::report
