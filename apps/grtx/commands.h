// The commands of the `grtx` program: one file a command. Each add_NAME registers its subcommand with options and
// defaults, and hands main the body to run once the whole command line has been accepted.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "grtx/apps/grtx/command_files.h"

namespace grtx::frontend {
class SceneTracer;
}

namespace grtx::sim {

/// What main and the commands share.
struct CommonOptions {
  bool quiet = false;           ///< no progress; no text of a command whose result is a file or its exit code
  bool json = false;            ///< --json: one JSON document in place of text
  bool list_json = false;       ///< --list-json: what --json of each command prints
  CommandFiles files;           ///< what the chosen command reads and writes
  std::function<int()> action;  ///< body of the chosen command; returns 0 (done) or 1 (a check did not hold)
};

void add_synth(CLI::App& app, CommonOptions& common);
void add_convert(CLI::App& app, CommonOptions& common);
void add_info(CLI::App& app, CommonOptions& common);
/// kept: what the trace before has left, and this one leaves; none: nothing.
void add_trace(CLI::App& app, CommonOptions& common, std::shared_ptr<frontend::SceneTracer> kept = nullptr);
void add_reference(CLI::App& app, CommonOptions& common);
void add_compare(CLI::App& app, CommonOptions& common);
void add_trace_check(CLI::App& app, CommonOptions& common);
void add_trace_dump(CLI::App& app, CommonOptions& common);
void add_ray(CLI::App& app, CommonOptions& common);
void add_sim(CLI::App& app, CommonOptions& common);
void add_cost(CLI::App& app, CommonOptions& common);
void add_run(CLI::App& app, CommonOptions& common);
void add_stalls(CLI::App& app, CommonOptions& common);
void add_report(CLI::App& app, CommonOptions& common);
void add_correlate(CLI::App& app, CommonOptions& common);
void add_sweep(CLI::App& app, CommonOptions& common);
void add_search(CLI::App& app, CommonOptions& common);
void add_regress(CLI::App& app, CommonOptions& common);

}  // namespace grtx::sim
