// What to do about an error: the end of the one line that main prints.
#pragma once

#include <string>
#include <vector>

#include "grtx/base/error.h"

namespace grtx::sim {

/// A hint for an error: of which kind the named file is if another was wanted, which file may have been meant, which
/// command makes one, or else where to look. `arguments`: the command line without the program's name. "" if the error
/// itself says enough.
std::string next_step(const Error& error, const std::vector<std::string>& arguments);

}  // namespace grtx::sim
