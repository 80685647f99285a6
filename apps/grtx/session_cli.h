// Options that sweep and search share: the database, and where and how many points run.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "grtx/lab/sweep/plan.h"
#include "grtx/lab/sweep/session.h"

namespace grtx::sim {

/// -o, --launcher, --jobs, --sbatch, --program, --retry.
void add_session_options(CLI::App* command, SessionOptions& options);

/// "3 traces made, 1 structure built for them"; "" when none was made.
std::string describe(const TraceWork& work);

/// Puts a machine (--machine; "" for none) below whatever the plan says. Throws Error for one that does not exist.
void put_on_machine(SweepPlan& plan, const std::string& machine);

}  // namespace grtx::sim
