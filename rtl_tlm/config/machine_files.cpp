// SPDX-License-Identifier: Apache-2.0
// Where the project's machines lie, and the names that people give them.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <map>

#include "grtx/base/error.h"
#include "grtx/base/nearest_name.h"
#include "grtx/rtl_tlm/config/config_file.h"

namespace grtx::sim {
namespace {

namespace fs = std::filesystem;

std::string& folder_of_program() {
  static std::string folder;
  return folder;
}

/// Candidate folders: the installed one relative to the program, then the one given to set_machines_folder().
std::vector<fs::path> machines_folders() {
  std::error_code failed;
  const fs::path program = fs::read_symlink("/proc/self/exe", failed);
  const fs::path installed = program.parent_path() / ".." / GRTX_MACHINES_INSTALLED;
  return {installed.lexically_normal(), folder_of_program()};
}

fs::path machines_folder() {
  std::error_code failed;
  const std::vector<fs::path> folders = machines_folders();
  return fs::is_directory(folders.front(), failed) ? folders.front() : folders.back();
}

/// The machine that people mean: products, and files without their ending. "" if it is neither.
std::string meant(const std::string& name) {
  std::error_code failed;
  if (fs::is_regular_file(name + ".toml", failed)) return fmt::format("did you mean the file {}.toml?", name);
  if (fs::is_regular_file(name, failed)) return "it is a file, but a machine's file ends in .toml";
  std::string word;
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) word += static_cast<char>(std::tolower(c));
  }
  static const std::map<std::string, std::array<const char*, 2>> products = {
      {"rtx4090", {"ada", "an RTX 4090"}},       {"4090", {"ada", "an RTX 4090"}},
      {"rtx6000ada", {"ada", "an RTX 4090"}},    {"lovelace", {"ada", "an RTX 4090"}},
      {"rtx5090", {"blackwell", "an RTX 5090"}}, {"5090", {"blackwell", "an RTX 5090"}},
      {"rx9070xt", {"rdna4", "an RX 9070 XT"}},  {"9070xt", {"rdna4", "an RX 9070 XT"}},
      {"2060", {"rtx2060", "an RTX 2060"}},      {"turing", {"rtx2060", "an RTX 2060"}},
      {"table1", {"paper-charged", "Table I"}},  {"default", {"paper", "what every command takes"}}};
  const auto product = products.find(word);
  if (product == products.end()) return "";
  return fmt::format("did you mean {}, which is like {}?", product->second[0], product->second[1]);
}

}  // namespace

std::string machine_file(const std::string& machine) {
  if (machine.ends_with(".toml")) return machine;
  const std::vector<std::string> names = machine_names();
  if (names.empty()) {
    throw Error("--machine", machine,
                fmt::format("no machines are in {} or {}; a file of your own ends in .toml",
                            machines_folders().front().string(), machines_folders().back().string()));
  }
  if (std::find(names.begin(), names.end(), machine) == names.end()) {
    const std::string hint = meant(machine);
    throw Error("--machine", machine,
                fmt::format("is none of {}; {}", fmt::join(names, ", "),
                            hint.empty() ? fmt::format("the nearest is {}; a file of your own ends in .toml",
                                                       nearest_name(machine, names))
                                         : hint));
  }
  return (machines_folder() / (machine + ".toml")).string();
}

std::vector<std::string> machine_names() {
  std::vector<std::string> names;
  std::error_code failed;
  for (const auto& file : fs::directory_iterator(machines_folder(), failed)) {
    if (file.path().extension() == ".toml") names.push_back(file.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

void set_machines_folder(const std::string& folder) { folder_of_program() = folder; }

}  // namespace grtx::sim
