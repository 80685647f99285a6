// SPDX-License-Identifier: Apache-2.0
// The parts of a report's page. Each returns HTML; "" when there is nothing to say.
#pragma once

#include <string>
#include <vector>

#include "grtx/report/page/machine_figures.h"
#include "grtx/report/page/paper_targets.h"
#include "grtx/report/page/run_results.h"
#include "grtx/report/page/sweep_results.h"

namespace grtx::report {

/// A run, and cost and energy of its designs, in the same order.
struct ReportRun {
  RunResults results;
  std::string name;  ///< how it differs from the page's other runs; "" for a single run
  std::vector<MachineFigures> machines;

  /// `name`, or the description of a single run.
  const std::string& title() const { return name.empty() ? results.label : name; }
  /// "paper: grtx", or "grtx" for a single run.
  std::string bar_label(std::size_t design) const;
};

/// A sweep, and cost of the machines at the ends of its front.
struct ReportSweep {
  SweepResults results;
  std::string id;  ///< prefix of element ids in the page: sweep1, ...
  struct Machine {
    std::size_t point = 0;  ///< index in results.points
    std::string what;       ///< "fastest", "smallest of the front"
    MachineFigures figures;
  };
  std::vector<Machine> machines;
};

// Descriptions of results: machine, view, mode, limitations.
/// Sets the names of runs by how they differ.
void name_runs(std::vector<ReportRun>& runs);
/// Describes a run (machine, view, mode). limits: with the limitations of its results, which a page says once; else a
/// link to them.
std::string subject_html(const ReportRun& run, bool limits = false);
/// The same for a sweep's points: machines, modes, and the number of points that each note applies to. id: of the sweep
/// in the page.
std::string subject_html(const SweepResults& sweep, const std::string& id, bool limits = false);
/// The same for each run.
std::string subjects_html(const std::vector<ReportRun>& runs);
/// Whether runs are of one view and one way to draw it, on machines of different names: then times are compared.
bool are_side_by_side(const ReportRun& a, const ReportRun& b);
/// Times of each design on each machine, where runs differ in their machine alone, and in what machines differ; ""
/// if no runs do.
std::string side_by_side_html(const std::vector<ReportRun>& runs);
/// Runs that differ in their view alone, and so have a mean; groups of two or more.
using Views = std::vector<const ReportRun*>;
std::vector<Views> views_of_a_mean(const std::vector<ReportRun>& runs);
/// Of several views: which design is fastest in them, and the geometric means of speed-ups; "" if no runs share a mean.
std::string several_views_html(const std::vector<ReportRun>& runs);
/// Table of estimates beside the runs in cycle mode that differ from them in nothing else, and whether their intervals
/// hold; "" if there are none.
std::string estimates_held(const std::vector<ReportRun>& runs);
/// Table of the facts in which runs differ, one column per run, and why some cannot be compared; "" for a single run.
std::string apart_table(const std::vector<ReportRun>& runs);
/// machines_text() of runs, for captions.
std::string machines_of(const std::vector<ReportRun>& runs);
/// The same for a sweep's finished points.
std::string machines_of(const SweepResults& sweep);
/// Interval of a run's value of a paper's result, if it was estimated.
std::optional<Interval> interval_of(const RunTarget& target, const RunResults& run);
/// "1.9× to 2.1×"; "" without an interval. shown: number() or times().
std::string interval_text(const std::optional<Interval>& interval, std::string (*shown)(double));
/// The same in brackets and small print, to append to the value.
std::string interval_html(const std::optional<Interval>& interval, std::string (*shown)(double));
/// A chip that opens: the notes on a result. id: of the element, "" for none.
std::string notes_chip(std::size_t notes, const std::string& html, const std::string& id = "");
/// One paragraph per kind of note; a text shared by several designs appears once.
std::string notes_html(const std::vector<std::pair<std::string, sim::ResultNotes>>& by_name);

// Runs.
/// The first screen of a run: the answer, the picture, speed-ups with what binds each, and where the bytes went.
std::string run_headline(const ReportRun& run, std::size_t index);
/// Paragraph: which design wins, by how much, and what binds it.
std::string run_answer(const ReportRun& run);
/// Paragraph: why it wins, its memory traffic, and what it waits for.
std::string run_verdict(const ReportRun& run);
/// The design of the fewest cycles.
const DesignResult& fastest(const RunResults& run);
/// "the longest ray, 59 %": the largest lower bound, and its share of the cycles, or "latency: one warp is 83 % of the
/// run" if that is more; "" if not recorded. Plain text.
std::string binding_text(const DesignResult& design);
/// Share of the time of resident warps that they spend in traceRay calls; NaN if not recorded.
double traversal_share(const DesignResult& design);
/// The design of the fewest cycles but for `best`; nullptr if there is none.
const DesignResult* next_to(const DesignResult& best, const RunResults& run);
/// dB of pictures, of several frames from the least to the most: "36.0 dB", "29.1 dB to 36.0 dB", "identical".
std::string decibels_text(const std::vector<double>& frames);
/// Over the run's reference, with its interval, as HTML; "" without a reference.
std::string speedup_text(const ReportRun& run, const DesignResult& design);
std::string paper_section(const std::vector<ReportRun>& runs);
std::string run_section(const ReportRun& run, std::size_t index);
/// Stalls and energy of all designs of all runs.
std::string bars_section(const std::vector<ReportRun>& runs);

// Sweeps.
std::string sweep_headline(const ReportSweep& sweep);
std::string sweep_section(const ReportSweep& sweep);
/// Points of an earlier plan.
std::string earlier_table(const SweepResults& results);

// Searches: meta.search of a sweep's database.
std::string search_headline(const ReportSweep& sweep);
std::string search_section(const ReportSweep& sweep);

// Both.
/// Storage, area and energy by hierarchy. title: plain text naming the machine.
std::string cost_section(const MachineFigures& machine, const std::string& title);
std::string configuration_section(const std::vector<ReportRun>& runs, const std::vector<ReportSweep>& sweeps);

/// A figure with a picture. uri: data: URI; caption: plain text.
std::string picture(const std::string& uri, const std::string& caption);
/// One headline figure: value is HTML, the others plain text.
std::string headline(const std::string& value_html, const std::string& what, const std::string& note);

}  // namespace grtx::report
