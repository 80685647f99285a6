// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/scene/file_beside.h"

#include <filesystem>

#include "grtx/base/error.h"

namespace grtx::frontend {

std::string read_beside(const std::string& file, const std::string& name, FilesRead& files) {
  const std::filesystem::path path(name);
  bool stays = !name.empty() && path.is_relative() && name.find('\0') == std::string::npos;
  for (const auto& part : path) stays = stays && part != "..";
  if (!stays) throw Error(file, name, "must be a file beside it");
  return files.read((std::filesystem::path(file).parent_path() / path).string(), name);
}

}  // namespace grtx::frontend
