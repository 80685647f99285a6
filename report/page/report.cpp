// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/page/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/explore/sweep/designs.h"
#include "grtx/report/page/html.h"
#include "grtx/report/page/page.h"
#include "grtx/report/page/sections.h"
#include "grtx/report/page/sweep_views.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;

struct Inputs {
  std::vector<ReportRun> runs;
  std::vector<ReportSweep> sweeps;
};

/// Inputs that determine the units of a machine. If the results do not record them, they are the design's own; of an
/// unknown design there are none, and its machine has no price.
ordered_json machine_inputs(const std::string& name, const ordered_json& inputs) {
  const auto design = std::ranges::find(explore::designs(), name, &explore::Design::name);
  if (inputs.contains("accel") || design == explore::designs().end()) return inputs;
  ordered_json all = {{"accel", design->accel}, {"checkpoint", design->checkpoint ? "on" : "off"}};
  for (const auto& [option, value] : design->tracer) all[option] = value;
  if (inputs.is_object()) all.update(inputs);
  return all;
}

/// Whether statistics of another design can be added to a run: same view and machine but for what the designs bring, so
/// ratios are speed-ups.
bool joins(const RunResults& run, const RunResults& other) {
  if (run.has_verdict || other.has_verdict || run.design(other.designs.front().name) != nullptr) return false;
  if (!run.subject.unknown().empty() || !other.subject.unknown().empty()) return false;
  return std::all_of(run.designs.begin(), run.designs.end(), [&](const DesignResult& design) {
    return design.subject.differences(other.subject, MayDiffer::designs).empty();
  });
}

/// Position of a design in tables.
std::ptrdiff_t place(const DesignResult& design) {
  return std::find(explore::design_names().begin(), explore::design_names().end(), design.name) -
         explore::design_names().begin();
}

/// Adds statistics of another design. The run is described by the design that tables have first.
void join(RunResults& run, RunResults other) {
  if (place(other.designs.front()) < place(run.designs.front())) std::swap(run, other);
  run.designs.insert(run.designs.end(), other.designs.begin(), other.designs.end());
  std::stable_sort(run.designs.begin(), run.designs.end(),
                   [](const DesignResult& a, const DesignResult& b) { return place(a) < place(b); });
  run.file += ", " + other.file;
  run.hash += ", " + other.hash;
  run.bytes += other.bytes;
  run.label = label_of(run);
}

void price_machines(ReportSweep& sweep) {
  const SweepViews shown(sweep.results);
  const auto add = [&](const char* value, const char* what) {
    const ShownPoint* best = nullptr;
    for (const ShownPoint& p : shown.points()) {
      if (p.view != 0 || !p.on_front() || !std::isfinite(shown.value(p, value))) continue;
      if (best == nullptr || shown.value(p, value) < shown.value(*best, value)) best = &p;
    }
    if (best == nullptr) return;
    for (const ReportSweep::Machine& known : sweep.machines) {
      if (known.point == best->points.front()) return;
    }
    const ReportedPoint& point = shown.first(*best);
    sweep.machines.push_back({best->points.front(), what,
                              machine_figures(point.config, machine_inputs(point.design, point.inputs), ordered_json(),
                                              sweep.results.file)});
  };
  add(kTime, "fastest of the front");
  add(sweep.results.area().c_str(), "smallest of the front");
}

Inputs read_inputs(const std::vector<std::string>& paths) {
  Inputs inputs;
  for (const std::string& path : paths) {
    if (is_database(path)) {
      ReportSweep& sweep = inputs.sweeps.emplace_back();
      sweep.results = read_sweep_results(path);
      sweep.id = fmt::format("sweep{}", inputs.sweeps.size());
      price_machines(sweep);
      continue;
    }
    for (RunResults& results : read_run_results(path)) {
      ReportRun* same = nullptr;
      for (ReportRun& run : inputs.runs) {
        if (joins(run.results, results)) same = &run;
      }
      if (same == nullptr) {
        inputs.runs.emplace_back().results = std::move(results);
      } else {
        join(same->results, std::move(results));
      }
    }
  }
  name_runs(inputs.runs);
  for (ReportRun& run : inputs.runs) {
    for (const DesignResult& design : run.results.designs) {
      run.machines.push_back(machine_figures(design.config, machine_inputs(design.name, design.inputs),
                                             design.statistics, run.results.file));
    }
  }
  return inputs;
}

std::string machines_section(const Inputs& inputs) {
  std::string out =
      "<section id=\"cost\"><h2>Storage and area</h2>\n"
      "<p>The paper gives no area and no energy: these figures are this model's own (docs/model/cost.md).</p>\n";
  for (const ReportRun& run : inputs.runs) {
    for (std::size_t i = 0; i < run.machines.size(); ++i) {
      const DesignResult& design = run.results.designs[i];
      const std::string subject = design.subject.text();
      const std::string title = (subject.empty() ? run.results.label : subject) + ", " + design.name;
      out += details("Machine of " + escape(run.bar_label(i)), cost_section(run.machines[i], title),
                     i + 1 == run.machines.size());
    }
  }
  for (const ReportSweep& sweep : inputs.sweeps) {
    for (const ReportSweep::Machine& machine : sweep.machines) {
      const std::string title =
          fmt::format("{} #{}, {}, {}, {}", sweep.results.file, sweep.results.points[machine.point].id,
                      sweep.results.points[machine.point].design, machine.what,
                      subject_of(sweep.results, sweep.results.points[machine.point]).machine_text());
      out += details("Machine of " + escape(title), cost_section(machine.figures, title),
                     &machine == &sweep.machines.front());
    }
  }
  return out + "</section>\n";
}

std::string run_inputs(const ReportRun& run) {
  std::vector<Table::Column> columns = {{"input", false}};
  std::vector<std::string> names;
  for (const DesignResult& design : run.results.designs) {
    columns.push_back({design.name, false});
    for (const auto& [name, value] : design.inputs.items()) {
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  }
  Table table(run.title() + ": inputs of the simulations", columns);
  for (const std::string& name : names) {
    std::vector<std::string> cells = {escape(name)};
    for (const DesignResult& design : run.results.designs) {
      cells.push_back(design.inputs.contains(name) ? cell(design.inputs.at(name)) : "");
    }
    table.row(cells);
  }
  return table.rows() == 0 ? "" : details(escape(run.title()) + ": inputs of the simulations", table.html());
}

std::string inputs_section(const Inputs& inputs, const std::vector<std::string>& images) {
  Table files("What this page was made of", {{"file", false}, {"kind", false}, {"XXH3", false}, {"of program", false}});
  std::string more;
  const RunResults* before = nullptr;  // the machines of a file follow each other
  for (const ReportRun& run : inputs.runs) {
    if (before == nullptr || before->file != run.results.file || before->hash != run.results.hash ||
        before->subject.setting("machine") == run.results.subject.setting("machine")) {
      files.row({escape(run.results.file), "run", escape(run.results.hash), escape(run.results.program)});
    }
    before = &run.results;
    more += run_inputs(run);
  }
  for (const ReportSweep& sweep : inputs.sweeps) {
    const auto meta = [&](const char* name) {
      const auto found = sweep.results.meta.find(name);
      return found == sweep.results.meta.end() ? std::string() : found->second;
    };
    files.row({escape(sweep.results.file), "sweep", escape(sweep.results.hash) + " (of its points)",
               escape(meta("program"))});
  }
  for (const std::string& image : images) {
    files.row({escape(std::filesystem::path(image).filename().string()), "picture", hex(xxh3(read_file(image))), ""});
  }
  return "<section id=\"inputs\"><h2>Inputs</h2>\n" + files.html() + more + "</section>\n";
}

std::string pictures_section(const std::vector<std::string>& images) {
  if (images.empty()) return "";
  std::string out = "<section id=\"pictures\"><h2>Pictures</h2>\n<div class=\"pictures\">\n";
  for (const std::string& path : images) {
    out += picture(picture_uri(path), std::filesystem::path(path).filename().string());
  }
  return out + "</div></section>\n";
}

}  // namespace

std::string report_page(const ReportOptions& options) {
  const Inputs inputs = read_inputs(options.inputs);
  std::string body = "<section id=\"headline\"><h2>The answer</h2>\n" + several_views_html(inputs.runs) +
                     side_by_side_html(inputs.runs);
  for (std::size_t r = 0; r < inputs.runs.size(); ++r) body += run_headline(inputs.runs[r], r + 1);
  body += apart_table(inputs.runs);
  for (const ReportSweep& sweep : inputs.sweeps) body += search_headline(sweep) + sweep_headline(sweep);
  body += "</section>\n";
  for (const ReportSweep& sweep : inputs.sweeps) body += search_section(sweep) + sweep_section(sweep);
  if (!inputs.runs.empty()) body += paper_section(inputs.runs);
  for (std::size_t r = 0; r < inputs.runs.size(); ++r) body += run_section(inputs.runs[r], r + 1);
  if (!inputs.runs.empty()) body += bars_section(inputs.runs);
  body += pictures_section(options.images) + machines_section(inputs) +
          configuration_section(inputs.runs, inputs.sweeps) + inputs_section(inputs, options.images);
  return html_page(options.title, "report", body);
}

}  // namespace grtx::report
