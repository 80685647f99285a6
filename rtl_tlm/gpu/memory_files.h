// The files that configure a machine's memory system. Their bytes are part of what a result was made from: the
// configuration has their name alone.
#pragma once

#include "grtx/base/files_read.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {

/// dram.simulator.config and all files that it or they name, beside it or in a folder beside it, as the simulators look
/// for them. None where dram.model needs no file. Throws Error when one cannot be read.
FilesRead memory_files(const GpuConfig& config);

}  // namespace grtx::sim
