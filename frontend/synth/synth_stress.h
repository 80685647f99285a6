// SPDX-License-Identifier: Apache-2.0
// Small scenes that are hard for exactly one reason each; docs/model/synthetic-scenes.md lists the expected results.
#pragma once

#include <string>
#include <vector>

#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/scene/ply_writer.h"
#include "grtx/frontend/synth/synth.h"

namespace grtx::frontend {

struct StressScene {
  std::vector<PlyRow> rows;
  std::vector<Camera> cameras;
};

/// Names without the prefix "stress-".
std::vector<std::string> stress_names();
/// `name`: one of stress_names(). Has options.count rows where the scene's purpose allows it.
StressScene stress_scene(const std::string& name, const SynthOptions& options);

}  // namespace grtx::frontend
