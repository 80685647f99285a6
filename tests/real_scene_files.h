// SPDX-License-Identifier: Apache-2.0
// Finds the trained scenes that are not part of the project: GRTX_SCENES (a folder of .ply or .ply.xz files) or
// ../shared/scenes beside it. Cameras lie in the same folder or in ../shared/scenes.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "paths.h"

namespace grtx::test {

inline std::string shared_scenes() { return grtx::paths::source_dir() + "/../shared/scenes"; }

/// Path of an unpacked .ply; unpacks NAME.ply.xz into the temporary folder with xz. "" when the scene is missing.
inline std::string real_scene_path(const std::string& name) {
  const char* named = std::getenv("GRTX_SCENES");
  const std::string folder = named != nullptr ? named : shared_scenes();
  const std::string plain = folder + "/" + name + ".ply";
  if (std::filesystem::exists(plain)) return plain;
  if (!std::filesystem::exists(plain + ".xz")) return "";
  const std::string unpacked = testing::TempDir() + "/grtx_" + name + ".ply";
  if (!std::filesystem::exists(unpacked)) {
    const std::string partial = unpacked + "." + std::to_string(::getpid());
    if (std::system(("xz -dkc '" + plain + ".xz' > '" + partial + "'").c_str()) != 0) return "";
    std::filesystem::rename(partial, unpacked);
  }
  return unpacked;
}

/// Path of NAME.cameras.json, "" when it is missing.
inline std::string real_cameras_path(const std::string& name) {
  if (const char* named = std::getenv("GRTX_SCENES")) {
    const std::string beside = std::string(named) + "/" + name + ".cameras.json";
    if (std::filesystem::exists(beside)) return beside;
  }
  const std::string shared = shared_scenes() + "/" + name + ".cameras.json";
  return std::filesystem::exists(shared) ? shared : "";
}

}  // namespace grtx::test
