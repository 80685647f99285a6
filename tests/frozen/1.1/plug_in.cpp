// SPDX-License-Identifier: Apache-2.0
// A plug-in of another simulator, loaded at run time: the configuration of a machine and what a trace holds.
#include <cstdint>
#include <string>
#include <systemc>

#include "grtx/base/error.h"
#include "grtx/rtl_tlm/config/config_file.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/traces/reader.h"

int sc_main(int, char*[]) { return 0; }  // SystemC asks for one, though it is not the main program here

extern "C" unsigned grtx_sms(const char* setting) {
  try {
    return grtx::sim::load_config("", {setting}).sms;
  } catch (const grtx::Error&) {
    return 0;
  }
}

extern "C" std::uint64_t grtx_groups(const char* trace) {
  const grtx::traces::Reader reader(trace);
  return reader.header().groups;
}
