// SPDX-License-Identifier: Apache-2.0
// Inputs of a simulation: "inputs" of its statistics.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

/// Hash of a trace's camera; "" where its header does not say.
std::string camera_of(const traces::Reader& trace);

/// Adds the traces that warmed the caches. ran: content hashes of the traces, "" if none did. camera: hash of the last
/// one's: traces of two designs differ even for the same view.
void add_run_before(std::map<std::string, std::string>& inputs, const std::string& ran, const std::string& camera);

/// Name -> hash or value: trace, image size, configuration, mode, program, and as "memory.*" the files that configure
/// the memory. Entries of later versions are left out at their default, so that documents on record stay as they are.
std::map<std::string, std::string> simulation_inputs(const traces::Reader& trace, const GpuConfig& config);

}  // namespace grtx::sim
