// Options that sweep and search share: the database, and where and how many points run.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "grtx/lab/sweep/session.h"

namespace grtx::sim {

/// Adds -o, --launcher, --jobs, --sbatch, --program and --retry.
void add_session_options(CLI::App* command, SessionOptions& options);

/// "3 traces made, 1 structure built for them"; "" if none was made.
std::string describe(const TraceWork& work);

}  // namespace grtx::sim
