// SPDX-License-Identifier: Apache-2.0
// grtx search: looks for the best machines of a design space.
#include "grtx/explore/search/search.h"

#include <fmt/format.h>

#include <memory>
#include <optional>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/json_output.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/apps/grtx/session_cli.h"
#include "grtx/base/error.h"
#include "grtx/experiment/machine.h"
#include "grtx/experiment/plan_machine.h"
#include "grtx/experiment/sweep_tracer_rules.h"
#include "grtx/explore/search/search_plan.h"
#include "grtx/explore/sweep/session.h"

namespace grtx::apps {
namespace {

struct SearchArguments {
  std::string plan;
  explore::SessionOptions session;
  std::string machine = experiment::kDefaultMachine;
  CLI::Option* machine_option = nullptr;
};

int search(const SearchArguments& options, const CommonOptions& common) {
  const bool quiet = common.quiet;
  if (options.session.database.empty()) throw Error("search", "-o", "a database is needed");
  const experiment::SceneTracerRules tracer;
  explore::SearchPlan plan = explore::load_search_plan(options.plan, tracer);
  const auto asked = options.machine_option->count() > 0 ? std::optional(options.machine) : std::nullopt;
  for (const std::string& file : experiment::put_on_machine(plan.common, asked)) common.files.check(file);
  explore::SessionOptions with = options.session;
  with.quiet = quiet;
  with.modes = {plan.common.mode, plan.confirm};
  explore::SweepSession session(with, plan.common);
  const nlohmann::ordered_json result = explore::run_search(plan, tracer, session, quiet);
  session.end();
  if (common.json) {
    print_json(result);
  } else if (!quiet) {
    if (session.trace_work().made != 0) fmt::print("{}\n", describe(session.trace_work()));
    fmt::print("{}{}\n", explore::search_text(result), next_report(options.session.database));
  }
  return explore::search_succeeded(result) ? 0 : 1;
}

}  // namespace

void add_search(CLI::App& app, CommonOptions& common) {
  const auto options = std::make_shared<SearchArguments>();
  CLI::App* command =
      make_command(app, common, "search", "Finds the front of a design space; results in a sweep's SQLite database",
                   [options, &common] { return search(*options, common); });
  command->add_option("PLAN", options->plan, "Plan in TOML, docs/guide/search.md (no default)")
      ->type_name(kInputFile)
      ->required();
  add_session_options(command, options->session);
  options->machine_option = add_machine_option(command, options->machine)->default_str("the plan's, else paper");
}

}  // namespace grtx::apps
