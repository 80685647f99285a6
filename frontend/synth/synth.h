// SPDX-License-Identifier: Apache-2.0
// Generated scenes with the statistics of trained ones. Same preset, count and seed give the same bytes on every host.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace grtx::frontend {

struct SynthOptions {
  std::string preset = "hall";  ///< one of synth_presets()
  std::uint64_t count = 100000;
  std::uint64_t seed = 1;
  unsigned sh_degree = 2;
};

/// Names accepted as preset.
std::vector<std::string> synth_presets();

/// "F.cameras.json", F = path without .ply.
std::string synth_cameras_path(const std::string& path);

/// Writes an INRIA .ply to `path` and cameras to synth_cameras_path(path). Throws Error.
void synthesise(const SynthOptions& options, const std::string& path);

}  // namespace grtx::frontend
