// What to do about an error: the end of the one line that main prints.
#pragma once

#include <string>
#include <vector>

#include "grtx/base/error.h"

namespace grtx::sim {

/// Says what the named file is when another kind was wanted, which file may have been meant, or which command makes
/// one; else where to look. `arguments`: the command line without the program's name. "" if the rule itself says
/// enough.
std::string next_step(const Error& error, const std::vector<std::string>& arguments);

}  // namespace grtx::sim
