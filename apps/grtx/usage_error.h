// SPDX-License-Identifier: Apache-2.0
// Error messages for invalid command lines.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "grtx/base/error.h"

namespace grtx::apps {

/// One-line error for an invalid command line: names the option and the rule, or the nearest known command or option.
Error usage_error(const CLI::App& app, const CLI::ParseError& error);

/// Throws Error for an option whose value is empty, or that another option follows where its value should be: the
/// parser would take that one as the value. Explicit values as in --stats=--odd are taken as they are.
void refuse_missing_values(const CLI::App& app, const std::vector<std::string>& arguments);

/// Throws Error for numbers that the parser takes and no option means: NaN, and a negative one where it wraps around.
void refuse_odd_numbers(const CLI::App& command);

}  // namespace grtx::apps
