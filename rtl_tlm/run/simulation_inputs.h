// What a simulation is of, for "inputs" of its statistics.
#pragma once

#include <map>
#include <string>

#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

/// Trace, its image in pixels, configuration, program, and "memory.files" of a memory that files configure: name ->
/// hash or value. What came later is left out where it has its default, so that documents on record stay as they are.
std::map<std::string, std::string> simulation_inputs(const traces::Reader& trace, const GpuConfig& config);

}  // namespace grtx::sim
