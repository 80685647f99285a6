// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/sweep/marked_folder.h"

#include <filesystem>
#include <vector>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"

namespace grtx::explore {
namespace {

namespace fs = std::filesystem;
constexpr const char* kMark = ".grtx-work";

bool is_own(const std::string& path) {
  std::error_code none;
  const fs::file_status status = fs::symlink_status(path, none);
  if (status.type() == fs::file_type::not_found) return true;
  if (!fs::is_directory(status)) return false;
  if (fs::is_regular_file(fs::symlink_status(path + "/" + kMark, none))) return true;
  // If make() or remove() was killed, the folder is empty or holds an incomplete mark.
  for (const auto& entry : fs::directory_iterator(path)) {
    if (!entry.path().filename().string().starts_with(kMark)) return false;
  }
  return true;
}

}  // namespace

MarkedFolder::MarkedFolder(std::string path) : path_(std::move(path)) {
  if (is_own(path_)) return;
  throw Error(path_, "",
              std::string("is no work folder that may be deleted (it holds no ") + kMark + "): move it away");
}

void MarkedFolder::make() const {
  fs::create_directories(path_);
  write_file(path_ + "/" + kMark, "Made by grtx for what is under way. It is deleted with all that it holds.\n");
}

void MarkedFolder::remove() const {
  try {
    if (!is_own(path_)) return;
    std::vector<fs::path> parts;
    for (const auto& entry : fs::directory_iterator(path_)) {
      if (entry.path().filename() != kMark) parts.push_back(entry.path());
    }
    for (const fs::path& part : parts) fs::remove_all(part);
    fs::remove_all(path_);  // mark last: if killed, the rest is still marked
  } catch (const fs::filesystem_error&) {
  }
}

}  // namespace grtx::explore
