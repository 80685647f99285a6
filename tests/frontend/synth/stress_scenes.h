// SPDX-License-Identifier: Apache-2.0
// Generated scenes with their cameras, loaded through the file as any other scene.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/scene/scene_io.h"
#include "grtx/frontend/synth/synth.h"

namespace grtx::test {

struct GeneratedScene {
  frontend::Scene scene;
  std::vector<frontend::Camera> cameras;
};

inline GeneratedScene generated_scene(const std::string& preset, std::uint64_t count, unsigned sh_degree = 1) {
  const std::string stem = testing::TempDir() + "grtx_generated_" + std::to_string(::getpid());
  frontend::synthesise({preset, count, 1, sh_degree}, stem + ".ply");
  GeneratedScene result{frontend::load_scene(stem + ".ply"), frontend::load_cameras(stem + ".cameras.json")};
  std::filesystem::remove(stem + ".ply");
  std::filesystem::remove(stem + ".cameras.json");
  return result;
}

/// `view` at `pixels` x `pixels`, made odd where the scene's middle pixel matters (stress-axis).
inline frontend::Camera small_view(const GeneratedScene& generated, std::size_t view, unsigned pixels) {
  const frontend::Camera& camera = generated.cameras.at(view);
  const unsigned size = camera.width % 2 == 1 ? pixels | 1u : pixels;
  return camera.resized(size, size);
}

inline std::string preset_test_name(const testing::TestParamInfo<std::string>& param) {
  std::string name = param.param;
  for (char& c : name) c = c == '-' ? '_' : c;
  return name;
}

}  // namespace grtx::test
