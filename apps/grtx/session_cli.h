// SPDX-License-Identifier: Apache-2.0
// Options that sweep and search share: the database, and where and how many points run.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "grtx/explore/sweep/session.h"

namespace grtx::apps {

/// Adds -o, --launcher, --jobs, --sbatch, --program and --retry.
void add_session_options(CLI::App* command, explore::SessionOptions& options);

/// "next: grtx report s.sqlite -o s.html"
std::string next_report(const std::string& database);

/// "3 traces made, 1 structure built for them"; "" if none was made.
std::string describe(const explore::TraceWork& work);

}  // namespace grtx::apps
