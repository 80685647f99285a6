// What a run leaves in caches and open DRAM rows, in a file, for a run in another process: `grtx sim --save-state`, and
// `--warm-state`, which is then as `--warm` with the trace that ran.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

struct SavedState {
  std::string mode;  ///< of simulation
  std::string config_hash;
  std::string hardware;            ///< hardware_of() the traces
  std::string scene;               ///< addressed_scene() of them
  std::string ran;                 ///< content hashes of the traces, in order
  std::string camera;              ///< hash of the camera of the last of them; "" where its trace does not say
  std::uint64_t memory_bytes = 0;  ///< that these needed
  std::string units;               ///< of caches and rows
};

void write_state(const std::string& path, const SavedState& state);
/// Throws Error for a file that is none, damaged, or of another version of model or file.
SavedState read_state(const std::string& path);
/// Throws Error{path, ...} unless the state is for this machine, this trace's hardware and scene, and this engine.
void require_fits(const SavedState& state, const std::string& path, const GpuConfig& config,
                  const traces::Reader& trace, const std::string& mode);

}  // namespace grtx::sim
