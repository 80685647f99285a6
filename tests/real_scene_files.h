// Where the trained scenes lie: the folder named by GRTX_SCENES, else ../shared/scenes beside the project. They are not
// part of the project; tests skip without them.
#pragma once

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace grtx::test {

inline constexpr const char* kNoRealScenes =
    "no real scenes: put them into ../shared/scenes or name the folder in GRTX_SCENES";

/// "" where there is none.
inline std::string real_scene_folder() {
  if (const char* named = std::getenv("GRTX_SCENES")) return named;
  const std::filesystem::path beside = std::filesystem::path(GRTX_SOURCE_DIR) / ".." / "shared" / "scenes";
  return std::filesystem::is_directory(beside) ? beside.string() : "";
}

/// Path of NAME.ply; NAME.ply.xz is unpacked into the system's temporary folder with xz. "" when the scene is missing.
inline std::string real_scene_path(const std::string& name) {
  const std::string folder = real_scene_folder();
  if (folder.empty()) return "";
  const std::string plain = folder + "/" + name + ".ply";
  if (std::filesystem::exists(plain)) return plain;
  if (!std::filesystem::exists(plain + ".xz")) return "";
  const std::string unpacked = (std::filesystem::temp_directory_path() / ("grtx_" + name + ".ply")).string();
  if (!std::filesystem::exists(unpacked)) {
    const std::string partial = unpacked + "." + std::to_string(::getpid());
    if (std::system(("xz -dkc '" + plain + ".xz' > '" + partial + "'").c_str()) != 0) return "";
    std::filesystem::rename(partial, unpacked);
  }
  return unpacked;
}

}  // namespace grtx::test
