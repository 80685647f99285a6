// SPDX-License-Identifier: Apache-2.0
// The tracer's options on the command line, shared by `trace` and `run`; some of them by `reference`.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "grtx/experiment/machine.h"
#include "grtx/experiment/tracer_settings.h"

namespace grtx::apps {

void add_kernel_degree(CLI::App* command, unsigned& degree);
/// Adds the options for glass and mirror.
void add_secondary_options(CLI::App* command, experiment::SecondarySettings& settings);
void add_tracer_options(CLI::App* command, experiment::TracerSettings& settings);
/// Applies the machine's tracer options, except those given on the command line.
void apply_tracer(experiment::TracerSettings& settings, const experiment::ChosenMachine& machine,
                  const CLI::App& command);

}  // namespace grtx::apps
