// SPDX-License-Identifier: Apache-2.0
// The `grtx` program as a function, for user programs that register additional configuration keys and units before
// calling it. They are then available in all commands.
#pragma once

#include <systemc>  // a program that calls program() defines sc_main()

#include "grtx/experiment/machines_folder.h"

namespace grtx {

/// Call once, from sc_main(). machines: folder of the named machines. Returns the exit code: 0 success, 1 a check or
/// comparison failed, 2 bad input or usage, 3 internal error.
int program(int argc, char** argv, const char* machines);

/// Prints an out-of-memory error and exits at once: unwinding could need more memory. Output files stay as after a
/// kill: the old version remains.
[[noreturn]] void end_without_memory();

}  // namespace grtx
