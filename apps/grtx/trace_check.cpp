// SPDX-License-Identifier: Apache-2.0
// grtx trace-check: replays a trace file and checks that it obeys the rules of the format.
#include <memory>
#include <nlohmann/json.hpp>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/json_output.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/base/error.h"
#include "grtx/base/json.h"
#include "grtx/traces/check.h"
#include "grtx/traces/count_totals.h"
#include "grtx/traces/reader.h"

namespace grtx::apps {
namespace {

int check_trace(const std::string& path, bool json, bool quiet) {
  const traces::Reader reader(path);
  reader.verify_content();  // damaged file: bad input (exit 2); violated rule: exit 1
  try {
    const traces::Totals totals = traces::check(reader, quiet);
    if (json) {
      nlohmann::ordered_json document = json_document("trace-check");
      document["file"] = path;
      document["groups"] = reader.group_count();
      document["totals"] = parse_json(traces::totals_to_json(totals), "totals");
      print_json(document);
    } else if (!quiet) {
      say("{}: consistent: {} groups, {} rays, {} rounds, {} visits, {} any-hit calls, {} checkpoints", path,
          reader.group_count(), totals.rays, totals.rounds, totals.visits(), totals.any_hit_calls,
          totals.checkpoints_written);
    }
    return 0;
  } catch (const Error& error) {
    throw CheckFailed(error);
  }
}

}  // namespace

void add_trace_check(CLI::App& app, CommonOptions& common) {
  const auto path = std::make_shared<std::string>();
  CLI::App* command = make_command(app, common, "trace-check", "Proves a trace file consistent",
                                   [path, &common] { return check_trace(*path, common.json, common.quiet); });
  command->add_option("TRACE", *path, "Trace file")->type_name(kInputFile)->required();
}

}  // namespace grtx::apps
