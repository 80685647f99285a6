// SPDX-License-Identifier: Apache-2.0
// The smallest program around `grtx`: this header is all that it includes.
#include "grtx/apps/grtx/program.h"

int sc_main(int argc, char** argv) { return grtx::program(argc, argv, grtx::kMachinesFolder); }
