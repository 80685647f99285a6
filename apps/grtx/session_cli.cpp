// SPDX-License-Identifier: Apache-2.0
#include "grtx/apps/grtx/session_cli.h"

#include <fmt/format.h>

#include <filesystem>

#include "grtx/apps/grtx/options.h"

namespace grtx::apps {

void add_session_options(CLI::App* command, explore::SessionOptions& options) {
  command
      ->add_option(
          "-o,--output", options.database,
          "Database to fill; points that it holds are not run again, and those that this call does not ask "
          "for are of an earlier plan: marked, and compared with nothing; traces go to the folder traces beside "
          "it (no default)")
      ->type_name(kOutputFile);
  command->add_option("--launcher", options.launcher, "Processes of this machine, or a job array of Slurm")
      ->check(one_of({"local", "slurm"}));
  command->add_option("--jobs", options.jobs, "Points at a time; 0: one per core, or as many as Slurm grants");
  command->add_option("--sbatch", options.slurm_options,
                      "Further options for sbatch, in one text: \"-p long -A project\" (default: none)");
  command->add_option("--program", options.program, "The grtx that traces and simulates (default: this one)");
  command->add_flag("--retry", options.retry,
                    "Run points again that failed, were killed or took too long (default: off)");
}

std::string next_report(const std::string& database) {
  return fmt::format("next: grtx report {} -o {}", database,
                     std::filesystem::path(database).replace_extension(".html").string());
}

std::string describe(const explore::TraceWork& work) {
  if (work.made == 0) return "";
  return fmt::format("{} {} made, {} {} built for them", work.made, work.made == 1 ? "trace" : "traces",
                     work.structures_built, work.structures_built == 1 ? "structure" : "structures");
}

}  // namespace grtx::apps
