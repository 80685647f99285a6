// The parts of a report's page. Each returns HTML; "" when there is nothing to say.
#pragma once

#include <string>
#include <vector>

#include "grtx/view/report/machine_figures.h"
#include "grtx/view/report/paper_targets.h"
#include "grtx/view/report/run_results.h"
#include "grtx/view/report/sweep_results.h"

namespace grtx::sim {

/// A run and what the cost model says of each of its designs, in their order.
struct ReportRun {
  RunResults results;
  std::string name;  ///< what sets it apart from the page's other runs; "" when it is alone
  std::vector<MachineFigures> machines;

  /// Its name, of one that is alone what it is of.
  const std::string& title() const { return name.empty() ? results.label : name; }
  /// "paper: grtx", or "grtx" when the run is alone.
  std::string bar_label(std::size_t design) const;
};

/// A sweep and the machines of the points at the ends of its front.
struct ReportSweep {
  SweepResults results;
  std::string id;  ///< of its elements in the page: sweep1, ...
  struct Machine {
    std::size_t point = 0;  ///< in results.points
    std::string what;       ///< "fastest", "smallest of the front"
    MachineFigures figures;
  };
  std::vector<Machine> machines;
};

// What figures are of.
/// Names runs by what sets them apart.
void name_runs(std::vector<ReportRun>& runs);
/// What a run's figures are of, and what limits their meaning.
std::string subject_html(const ReportRun& run);
/// The same of a sweep's points: machines, modes, and how many points each note limits.
std::string subject_html(const SweepResults& sweep);
/// The same of each run.
std::string subjects_html(const std::vector<ReportRun>& runs);
/// The facts in which several runs differ, a column a run, and why some are not compared; "" of a run that is alone.
std::string apart_table(const std::vector<ReportRun>& runs);
/// machines_text() of runs: for captions of figures of all.
std::string machines_of(const std::vector<ReportRun>& runs);
/// The same of a sweep's finished points.
std::string machines_of(const SweepResults& sweep);
/// Of a figure of the paper that a run has with an interval.
std::optional<Interval> interval_of(const RunTarget& target, const RunResults& run);
/// "1.9× to 2.1×"; "" without an interval. shown: number() or times().
std::string interval_text(const std::optional<Interval>& interval, std::string (*shown)(double));
/// The same in brackets, small, behind its figure.
std::string interval_html(const std::optional<Interval>& interval, std::string (*shown)(double));
/// A paragraph a note; that of several designs once.
std::string notes_html(const std::vector<std::pair<std::string, ResultNotes>>& by_name);

// Runs.
std::string run_headline(const ReportRun& run);
/// A paragraph: which design wins and why, where its bytes went, what binds it.
std::string run_verdict(const ReportRun& run);
/// Bytes of L2 and DRAM by what they were for, checkpoints apart.
std::string bytes_table(const ReportRun& run);
std::string paper_section(const std::vector<ReportRun>& runs);
std::string run_section(const ReportRun& run, std::size_t index);
/// Stalls and energy of all designs of all runs.
std::string bars_section(const std::vector<ReportRun>& runs);

// Sweeps.
std::string sweep_headline(const ReportSweep& sweep);
std::string sweep_section(const ReportSweep& sweep);
/// Points of an earlier plan.
std::string earlier_table(const SweepResults& results);

// Searches: what meta.search of a sweep's database holds.
std::string search_headline(const ReportSweep& sweep);
std::string search_section(const ReportSweep& sweep);

// Both.
/// Storage, area and energy by hierarchy. title: plain text, that names the machine.
std::string cost_section(const MachineFigures& machine, const std::string& title);
std::string configuration_section(const std::vector<ReportRun>& runs, const std::vector<ReportSweep>& sweeps);

/// A figure with a picture: `uri` is data:, the caption plain text.
std::string picture(const std::string& uri, const std::string& caption);
/// One headline figure: value is HTML, the others plain text.
std::string headline(const std::string& value_html, const std::string& what, const std::string& note);

}  // namespace grtx::sim
