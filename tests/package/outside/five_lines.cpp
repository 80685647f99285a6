// SPDX-License-Identifier: Apache-2.0
// The shortest program with the GPU model: how it is found and linked is what is tested.
#include <systemc>

#include "grtx/rtl_tlm/gpu/gpu_config.h"

int sc_main(int, char*[]) { return grtx::sim::load_config("", {"gpu.sms=2"}).sms == 2 ? 0 : 1; }
