// SPDX-License-Identifier: Apache-2.0
#include "grtx/apps/grtx/program.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <iostream>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <system_error>
#include <systemc>
#include <vector>

#include "grtx/apps/grtx/build_stamp.h"
#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/help_format.h"
#include "grtx/apps/grtx/json_output.h"
#include "grtx/apps/grtx/selftest.h"
#include "grtx/apps/grtx/usage_error.h"
#include "grtx/base/end_by_signal.h"
#include "grtx/base/error.h"
#include "grtx/base/memory_purpose.h"
#include "grtx/experiment/machine.h"
#include "grtx/rtl_tlm/memory/dram_simulators.h"
#include "grtx/rtl_tlm/run/model_version.h"

namespace {

using grtx::apps::CommonOptions;

constexpr int kCheckFailed = 1;
constexpr int kBadInput = 2;
constexpr int kInternalError = 3;

void print_error(const grtx::Error& error) { std::fprintf(stderr, "grtx: %s\n", error.what()); }

// Lines of 80 columns.
constexpr const char* kFirstSession = R"(Five steps of a first session, minutes together:

  1. A scene of 400,000 Gaussians, and cameras for it
     grtx synth --preset object --count 400000 -o object.ply
  2. What is in it
     grtx info object.ply
  3. A picture of it
     grtx trace --scene object.ply --cameras object.cameras.json --width 512 \
       --height 512 --accel tlas-sphere --no-trace --k 64 --image o.png
  4. The designs simulated: speed-ups, and a report to open in a browser
     grtx run --scene object.ply --cameras object.cameras.json --width 64 \
       --height 64 -o out
  5. One of them on another machine: half the L1
     grtx sim out/grtx.grtx --machine paper --set l1.bytes=65536

Commands: grtx --help. Options of a command: grtx COMMAND --help.
)";

int run(int argc, char** argv, const std::vector<std::string>& arguments) {
  grtx::end_tidily_by_signals();  // before parsing, which tries output files
  CLI::App app("Hardware model of GRTX: ray tracing of 3D Gaussians. A command's options: grtx COMMAND --help", "grtx");
  app.formatter(std::make_shared<grtx::apps::HelpFormat>());
  app.set_version_flag("--version", fmt::format("grtx {}, model version {}, commit {}, {}", GRTX_VERSION,
                                                grtx::sim::kModelVersion, grtx::apps::kCommit, grtx::apps::kCompiler));
  CommonOptions common;
  app.add_flag("--list-json", common.list_json, "Describe the --json output of each command, as Markdown");
  grtx::apps::add_synth(app, common);
  grtx::apps::add_info(app, common);
  grtx::apps::add_convert(app, common);
  grtx::apps::add_trace(app, common);
  grtx::apps::add_reference(app, common);
  grtx::apps::add_compare(app, common);
  grtx::apps::add_trace_check(app, common);
  grtx::apps::add_trace_dump(app, common);
  grtx::apps::add_ray(app, common);
  grtx::apps::add_sim(app, common);
  grtx::apps::add_machine(app, common);
  grtx::apps::add_cost(app, common);
  grtx::apps::add_run(app, common);
  grtx::apps::add_stalls(app, common);
  grtx::apps::add_report(app, common);
  grtx::apps::add_correlate(app, common);
  grtx::apps::add_sweep(app, common);
  grtx::apps::add_search(app, common);
  grtx::apps::add_regress(app, common);
  grtx::apps::add_selftest(app, common);
  grtx::apps::refuse_missing_values(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {  // --help, --version
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    print_error(grtx::apps::usage_error(app, error));
    return kBadInput;
  }
  if (common.list_json) {
    fmt::print("{}", grtx::apps::json_reference());
    return 0;
  }
  if (!common.action) {
    std::fputs(kFirstSession, stderr);
    return kBadInput;
  }
  return common.action();
}

/// Throws Error if standard output could not be written completely.
void require_standard_output() {
  const bool flushed = std::fflush(stdout) == 0 && !std::cout.flush().fail();
  if (!flushed || std::ferror(stdout) != 0) throw grtx::Error("standard output", "", "cannot be written");
}

/// Runs the program and checks that all output was written.
int run_and_flush(int argc, char** argv, const std::vector<std::string>& arguments) {
  try {
    const int code = run(argc, argv, arguments);
    require_standard_output();
    return code;
  } catch (const std::system_error&) {  // from fmt::print
    require_standard_output();
    throw;
  }
}

}  // namespace

namespace grtx {

void end_without_memory() {
  const char* const purpose = grtx::MemoryPurpose::latest();
  std::array<char, 512> line{};
  const int length = std::snprintf(line.data(), line.size(), "grtx: internal error: out of memory%s%s\n",
                                   *purpose == 0 ? "" : ": ", purpose);
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, line.data(), static_cast<std::size_t>(length));
  ::_exit(kInternalError);
}

int program(int argc, char** argv, const char* machines) {
  const std::vector<std::string> arguments(argv + std::min(argc, 1), argv + argc);
  // SystemC warnings are errors of the model: they stop the program.
  sc_core::sc_report_handler::set_actions(sc_core::SC_WARNING, sc_core::SC_THROW);
  sc_core::sc_report_handler::set_actions(sc_core::SC_ERROR, sc_core::SC_THROW);
  sc_core::sc_report_handler::set_actions(sc_core::SC_FATAL, sc_core::SC_THROW);
  experiment::set_machines_folder(machines);
  try {
    sim::register_dram_simulators();
    return run_and_flush(argc, argv, arguments);
  } catch (const apps::CheckFailed& error) {
    print_error(error);
    return kCheckFailed;
  } catch (const grtx::Error& error) {
    print_error(error);
    return kBadInput;
  } catch (const std::filesystem::filesystem_error& error) {  // an invalid path
    print_error({error.path1().string(), "", error.code().message()});
    return kBadInput;
  } catch (const std::bad_alloc&) {
    end_without_memory();
  } catch (const std::exception& error) {
    print_error({"internal error", "", error.what()});
    return kInternalError;
  }
}

}  // namespace grtx
