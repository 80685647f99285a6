// SPDX-License-Identifier: Apache-2.0
// The external DRAM simulators that this build was linked with (GRTX_DRAMSYS, GRTX_RAMULATOR).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "grtx/rtl_tlm/memory/ported_dram.h"

namespace grtx::sim {

/// Those among "dramsys" and "ramulator": values of dram.model.
std::vector<std::string> dram_simulators();
/// Builds one of them by name, as a module called `module`.
std::unique_ptr<PortedDram> build_dram_simulator(const std::string& simulator, const char* module,
                                                 const PortedDramConfig& config);
/// Makes them values of dram.model. Call before configurations are read; further calls do nothing.
void register_dram_simulators();

}  // namespace grtx::sim
