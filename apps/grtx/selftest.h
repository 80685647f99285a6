// SPDX-License-Identifier: Apache-2.0
// grtx selftest: small runs of this program, compared with recorded hashes and numbers.
#pragma once

#include <CLI/CLI.hpp>

#include "grtx/apps/grtx/commands.h"

namespace grtx::apps {

/// Registers the command, as the functions of commands.h do.
void add_selftest(CLI::App& app, CommonOptions& common);

}  // namespace grtx::apps
