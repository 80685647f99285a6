// SPDX-License-Identifier: Apache-2.0
// A program that runs a regression with a unit of its own:
//   own_regression DIR [--update REASON]
// The L2 slices are made here, with a hit latency that the configuration does not have. A case on record with the
// project's own unit shows what that moves; a record made with --update holds for this program.
#include <fmt/format.h>

#include <memory>
#include <string>
#include <systemc>

#include "grtx/base/error.h"
#include "grtx/rtl_tlm/regress/regression.h"

namespace {

using grtx::sim::GpuConfig;
using grtx::sim::RegressionCase;

void slow_down(grtx::sim::GpuParts& parts) {
  parts.l2_slice = [](const char* name, const grtx::modules::L2SliceConfig& l2, grtx::modules::ClockDomain& clock) {
    grtx::modules::L2SliceConfig slower = l2;
    slower.latency += 10;
    return grtx::modules::make_l2_slice(name, slower, clock);
  };
}

grtx::sim::SimulationResult with_own_units(const RegressionCase& regression_case, const GpuConfig& config) {
  if (regression_case.mode != grtx::sim::SimulationMode::cycle) {
    throw grtx::Error(regression_case.file, "mode", "own units run in cycle mode only");
  }
  grtx::sim::SimulationOptions options;
  slow_down(options.build.parts);
  return grtx::sim::simulate(regression_case.trace, config, options);
}

}  // namespace

int sc_main(int argc, char** argv) {
  try {
    const bool update = argc == 4 && std::string(argv[2]) == "--update";
    if (argc != 2 && !update) throw grtx::Error("own_regression", "arguments", "DIR [--update REASON]");
    grtx::sim::RegressionOptions options;
    options.folder = argv[1];
    options.program = "own_regression";
    if (update) options.reason = argv[3];
    options.simulate = with_own_units;
    return exit_code(run_regression(options));
  } catch (const grtx::Error& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
