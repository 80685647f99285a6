// SPDX-License-Identifier: Apache-2.0
// Hints on how to fix an error, appended to the line that main prints.
#pragma once

#include <string>
#include <vector>

#include "grtx/base/error.h"

namespace grtx::apps {

/// Hint for an error: the kind of a file if another kind was expected, a file that may have been meant, the command
/// that makes such a file, or where to look. arguments: the command line without the program's name. "" if the error is
/// sufficient.
std::string next_step(const Error& error, const std::vector<std::string>& arguments);

}  // namespace grtx::apps
