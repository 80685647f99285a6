// The parts of a report's page. Each returns HTML; "" when there is nothing to say.
#pragma once

#include <string>
#include <vector>

#include "grtx/explore/report/machine_figures.h"
#include "grtx/explore/report/run_results.h"
#include "grtx/explore/report/sweep_results.h"

namespace grtx::sim {

/// A run and what the cost model says of each of its designs, in their order.
struct ReportRun {
  RunResults results;
  std::string name;  ///< "Run A", or "Run" when it is alone
  std::vector<MachineFigures> machines;

  /// "A grtx", or "grtx" when the run is alone.
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
/// Storage and area by hierarchy. cost: as `grtx cost --json`; title: plain text.
std::string cost_section(const MachineFigures& machine, const std::string& title);
std::string configuration_section(const std::vector<ReportRun>& runs, const std::vector<ReportSweep>& sweeps);

/// A figure with a picture: `uri` is data:, the caption plain text.
std::string picture(const std::string& uri, const std::string& caption);
/// One headline figure: value is HTML, the others plain text.
std::string headline(const std::string& value_html, const std::string& what, const std::string& note);

}  // namespace grtx::sim
