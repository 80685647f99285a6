// The `grtx` program as a function, for programs of your own: register keys and units, then call it. All of its
// commands then have them.
#pragma once

#include "grtx/study/machines_folder.h"

namespace grtx {

/// To be called from sc_main(), once. machines: folder of the machines that have a name. Returns the exit code: 0 done,
/// 1 a check or comparison did not hold, 2 bad input or usage, 3 internal error.
int program(int argc, char** argv, const char* machines);

/// Without memory nothing is worth unwinding: destructors and the libraries' handlers would ask for more. Files are
/// left as by a kill: the old one under its name.
[[noreturn]] void end_without_memory();

}  // namespace grtx
