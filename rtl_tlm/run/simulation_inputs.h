// SPDX-License-Identifier: Apache-2.0
// What a simulation was made from: "inputs" of its statistics.
#pragma once

#include <map>
#include <string>

#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

/// Name -> hash or value: trace, image size, configuration, program, and as "memory.*" the files that configure the
/// memory. Entries of later versions are left out at their default, so that documents on record stay as they are.
std::map<std::string, std::string> simulation_inputs(const traces::Reader& trace, const GpuConfig& config);

}  // namespace grtx::sim
