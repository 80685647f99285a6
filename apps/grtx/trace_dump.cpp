// SPDX-License-Identifier: Apache-2.0
// grtx trace-dump: prints a trace file as text, as JSON or as lists of reads.
#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <optional>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/base/error.h"
#include "grtx/traces/dump.h"
#include "grtx/traces/reader.h"

namespace grtx::apps {
namespace {

struct TraceDumpArguments {
  std::string trace;
  std::optional<std::uint64_t> warp;
  std::optional<unsigned> lane;
  bool nodes = false;
};

int dump_trace(const TraceDumpArguments& options, bool json) {
  const traces::Reader reader(options.trace);
  if (options.warp && *options.warp >= reader.group_count()) {
    throw Error(options.trace, fmt::format("--warp {}", *options.warp),
                fmt::format("the trace has {} warps, numbered from 0", reader.group_count()));
  }
  if (options.lane && *options.lane >= reader.header().warp_size) {
    throw Error(options.trace, fmt::format("--lane {}", *options.lane),
                fmt::format("a warp has {} lanes, numbered from 0", reader.header().warp_size));
  }
  if (options.nodes && json) throw Error("trace-dump", "--nodes", "is no JSON: leave out --json");
  const auto print = json ? traces::dump_json : options.nodes ? traces::dump_nodes : traces::dump;
  print(reader, std::cout, options.warp, options.lane);
  std::cout.flush();
  if (!std::cout) throw Error("standard output", "", "cannot be written");
  return 0;
}

}  // namespace

void add_trace_dump(CLI::App& app, CommonOptions& common) {
  const auto options = std::make_shared<TraceDumpArguments>();
  CLI::App* command = make_command(app, common, "trace-dump", "Prints a trace file",
                                   [options, &common] { return dump_trace(*options, common.json); });
  command->add_option("TRACE", options->trace, "Trace file")->type_name(kInputFile)->required();
  command->add_option("--warp", options->warp, "Only this warp (default: all)");
  command->add_option("--lane", options->lane, "Only this lane (default: all)");
  command->add_flag("--nodes", options->nodes,
                    "What each visit reads of the nodes, a line each, for other simulators (default: off)");
}

}  // namespace grtx::apps
