// SPDX-License-Identifier: Apache-2.0
// Contents of caches and open DRAM rows after a run, in a file, for a run in another process: `grtx sim --save-state`
// writes it; `--warm-state` then does what `--warm` does with the trace that ran.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

struct SavedState {
  std::string mode;  ///< simulation mode
  std::string config_hash;
  std::string hardware;            ///< hardware_of() the traces
  std::string scene;               ///< addressed_scene() of them
  std::string ran;                 ///< content hashes of the traces, in order
  std::string camera;              ///< hash of the camera of the last of them; "" where its trace does not say
  std::uint64_t memory_bytes = 0;  ///< that these traces needed
  std::string units;               ///< state of caches and rows, in bytes
};

void write_state(const std::string& path, const SavedState& state);
/// Throws Error for a file that is not a saved state, is damaged, or is of another version of model or file format.
SavedState read_state(const std::string& path);
/// Throws Error{path, ...} unless the state is for this machine, this mode, and this trace's hardware and scene.
void require_fits(const SavedState& state, const std::string& path, const GpuConfig& config,
                  const traces::Reader& trace, const std::string& mode);

}  // namespace grtx::sim
