// SPDX-License-Identifier: Apache-2.0
#include "grtx/base/files_read.h"

#include <filesystem>

#include "grtx/base/atomic_file.h"
#include "grtx/base/hash.h"

namespace grtx {

std::string FilesRead::read(const std::string& path, const std::string& name) {
  std::string bytes = read_file(path);
  note(path, bytes, name);
  return bytes;
}

void FilesRead::note(const std::string& path, std::string_view bytes, const std::string& name) {
  files_.push_back({path, name.empty() ? std::filesystem::path(path).filename().string() : name, xxh3(bytes)});
}

std::string FilesRead::hash() const {
  std::string hashes;
  for (const File& file : files_) hashes += hex(file.hash);
  return hex(xxh3(hashes));
}

std::map<std::string, std::string> FilesRead::inputs() const {
  std::string text;
  for (const File& file : files_) text += (text.empty() ? "" : ", ") + file.name + " " + hex(file.hash);
  return {{"files", text}, {kFilesHash, hash()}};
}

}  // namespace grtx
