// SPDX-License-Identifier: Apache-2.0
// The tracer's options on the command line, shared by `trace` and `run`; some of them by `reference`.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "grtx/study/machine.h"
#include "grtx/study/tracer_settings.h"

namespace grtx::apps {

void add_kernel_degree(CLI::App* command, unsigned& degree);
/// Adds the options for glass and mirror.
void add_secondary_options(CLI::App* command, study::SecondarySettings& settings);
void add_tracer_options(CLI::App* command, study::TracerSettings& settings);
/// Applies the machine's tracer options, except those given on the command line.
void apply_tracer(study::TracerSettings& settings, const study::ChosenMachine& machine, const CLI::App& command);

}  // namespace grtx::apps
