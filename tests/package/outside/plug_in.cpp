// SPDX-License-Identifier: Apache-2.0
// A shared library that links the static ones, as a simulator's plug-in or a Python extension does.
#include <systemc>

#include "grtx/rtl_tlm/gpu/gpu_config.h"

int sc_main(int, char*[]) { return 0; }  // SystemC asks for one, though it is not the main program here

extern "C" unsigned sms_of_the_default_machine() { return grtx::sim::load_config("", {}).sms; }
