// SPDX-License-Identifier: Apache-2.0
// The commands of the `grtx` program, one file per command. Each add_NAME() registers its subcommand with options and
// defaults; its body is stored in CommonOptions::action and run after the command line is parsed.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "grtx/apps/grtx/command_files.h"
#include "grtx/base/error.h"

namespace grtx::frontend {
class SceneTracer;
}

namespace grtx::apps {

/// The check that a command makes has failed: main prints the line and returns 1.
class CheckFailed : public Error {
 public:
  explicit CheckFailed(const Error& why) : Error(why) {}
};

/// State shared by main and the commands.
struct CommonOptions {
  bool quiet = false;           ///< no progress; no text if the result is a file or the exit code
  bool json = false;            ///< --json: print one JSON document instead of text
  bool list_json = false;       ///< --list-json: describe the --json output of each command
  CommandFiles files;           ///< files that the chosen command reads and writes
  std::function<int()> action;  ///< body of the chosen command; returns 0 (success) or 1 (a check failed)
};

void add_synth(CLI::App& app, CommonOptions& common);
void add_convert(CLI::App& app, CommonOptions& common);
void add_info(CLI::App& app, CommonOptions& common);
/// kept: scene and structure, reused from one trace to the next; null: not kept.
void add_trace(CLI::App& app, CommonOptions& common, std::shared_ptr<frontend::SceneTracer> kept = nullptr);
void add_reference(CLI::App& app, CommonOptions& common);
void add_compare(CLI::App& app, CommonOptions& common);
void add_trace_check(CLI::App& app, CommonOptions& common);
void add_trace_dump(CLI::App& app, CommonOptions& common);
void add_ray(CLI::App& app, CommonOptions& common);
void add_sim(CLI::App& app, CommonOptions& common);
void add_machine(CLI::App& app, CommonOptions& common);
void add_cost(CLI::App& app, CommonOptions& common);
void add_run(CLI::App& app, CommonOptions& common);
void add_stalls(CLI::App& app, CommonOptions& common);
void add_report(CLI::App& app, CommonOptions& common);
void add_correlate(CLI::App& app, CommonOptions& common);
void add_sweep(CLI::App& app, CommonOptions& common);
void add_search(CLI::App& app, CommonOptions& common);
void add_regress(CLI::App& app, CommonOptions& common);

}  // namespace grtx::apps
