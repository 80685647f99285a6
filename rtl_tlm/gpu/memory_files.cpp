// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/gpu/memory_files.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "grtx/base/atomic_file.h"
#include "grtx/rtl_tlm/gpu/memory_system.h"

namespace grtx::sim {
namespace {

namespace fs = std::filesystem;

/// Possible file names in JSON or YAML text: words and quoted strings.
std::set<std::string, std::less<>> words_of(std::string_view text) {
  std::set<std::string, std::less<>> words;
  for (const std::string_view between : {std::string_view("\"'\n\r"), std::string_view("\"'\n\r\t ,:[]{}")}) {
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = std::min(text.find_first_of(between, begin), text.size());
      if (end - begin > 2 && end - begin < 256) words.emplace(text.substr(begin, end - begin));
      begin = end + 1;
    }
  }
  return words;
}

/// The folder of a file, then the folders in it by name.
std::vector<fs::path> folders_of(const fs::path& file) {
  const fs::path own = file.has_parent_path() ? file.parent_path() : fs::path(".");
  std::vector<fs::path> folders;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(own, none)) {
    if (entry.is_directory(none)) folders.push_back(entry.path());
  }
  std::sort(folders.begin(), folders.end());
  folders.insert(folders.begin(), own);
  return folders;
}

}  // namespace

FilesRead memory_files(const GpuConfig& config) {
  FilesRead files;
  const std::vector<std::string> by_file = memory_systems_with_file();
  if (std::find(by_file.begin(), by_file.end(), config.dram_model) == by_file.end()) return files;
  const std::vector<fs::path> folders = folders_of(config.dram_simulator.file);
  std::set<std::string> seen;
  std::vector<std::string> named = {config.dram_simulator.file};
  while (!named.empty()) {
    const std::string path = named.back();
    named.pop_back();
    std::error_code none;
    if (!seen.insert(fs::weakly_canonical(path, none).string()).second) continue;
    check_regular_file(path);
    for (const std::string& word : words_of(files.read(path))) {
      for (const fs::path& folder : folders) {
        if (fs::is_regular_file(folder / word, none)) named.push_back((folder / word).string());
      }
    }
  }
  return files;
}

}  // namespace grtx::sim
