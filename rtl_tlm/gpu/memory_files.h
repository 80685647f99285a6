// SPDX-License-Identifier: Apache-2.0
// The files that configure a machine's memory system. Their contents are inputs of a result and are recorded with it:
// the configuration itself only has their name.
#pragma once

#include "grtx/base/files_read.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {

/// dram.simulator.config and, recursively, all files that it names, looked up in its folder and in the folders there,
/// as the simulators do. Empty if dram.model needs no file. Throws Error when a file cannot be read.
FilesRead memory_files(const GpuConfig& config);

}  // namespace grtx::sim
