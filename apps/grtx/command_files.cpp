// SPDX-License-Identifier: Apache-2.0
#include "grtx/apps/grtx/command_files.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/experiment/heatmap.h"
#include "grtx/experiment/run_designs.h"
#include "grtx/experiment/view_choice.h"
#include "grtx/frontend/synth/synth.h"
#include "grtx/rtl_tlm/observe/waveform.h"

namespace grtx::apps {
namespace {

namespace fs = std::filesystem;

std::string canonical(const std::string& path) {
  std::error_code unknown;
  const fs::path found = fs::weakly_canonical(fs::absolute(path, unknown), unknown);
  return unknown ? path : found.string();
}

/// Values of another option of the command; empty if it has no such option.
std::vector<std::string> results(const CLI::App& command, const std::string& name) {
  const CLI::Option* option = command.get_option_no_throw(name);
  return option == nullptr ? std::vector<std::string>() : option->results();
}

/// Files that the command writes for a value of an output option; the first is the file named by the value.
std::vector<std::string> written(const CLI::App& command, const CLI::Option& option, const std::string& text) {
  const std::string& name = option.get_name();
  if (name == "--heatmap") {
    const std::string picture = experiment::heatmap_path(text);
    return {picture, experiment::heatmap_values_path(picture)};
  }
  if (name == "--vcd") return {text, sim::save_file_of(text)};
  if (command.get_name() == "synth" && name == "--output") return {text, frontend::synth_cameras_path(text)};
  const std::vector<std::string> views = results(command, "--views");
  if (command.get_name() == "run") {
    return experiment::run_files(text, views.empty() ? "" : views.front(), results(command, "--machine"));
  }
  if (name == "--image" && !views.empty()) return experiment::frame_paths(text, views.front());
  if (command.get_name() == "sweep" || command.get_name() == "search") return {text, text + ".lock", text + ".work"};
  return {text};
}

/// Throws Error if what the option names cannot be written: before a scene is read, not after.
void require_writable(const CLI::App& command, const std::string& text) {
  const std::string& name = command.get_name();
  const bool database = name == "sweep" || name == "search";
  if (!database && name != "run") return check_writable(text);
  std::error_code failed;
  fs::path folder = fs::absolute(text, failed).lexically_normal();
  if (database) {  // a plan of many points takes a while to read
    if (command.get_option_no_throw("--list") != nullptr && command.count("--list") > 0) return;
    folder = folder.parent_path();
    if (!fs::is_directory(folder, failed)) throw Error(text, "", "there is no folder " + folder.string());
  }
  while (!fs::exists(folder, failed) && folder.has_relative_path()) folder = folder.parent_path();
  if (::access(folder.c_str(), W_OK) == 0) return;
  throw Error(text, "", fmt::format("cannot be written: {}: {}", folder.string(), std::strerror(errno)));
}

/// Whether `path` may be a filter file of a waveform's save file; their names depend on the signals.
bool is_filter_of(const std::string& save_file, const std::string& path) {
  return save_file.ends_with(".gtkw") && path.ends_with(".filter") &&
         path.starts_with(save_file.substr(0, save_file.size() - 4));
}

}  // namespace

CommandFiles::File CommandFiles::file_of(const std::string& path) {
  File file;
  file.path = canonical(path);
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode)) file.node = {status.st_dev, status.st_ino};
  return file;
}

void CommandFiles::add(const CLI::Option& option, const std::string& text, const std::string& path, bool output,
                       bool follows) {
  File& file = files_.emplace_back(file_of(path));
  file.option = option.get_name();
  file.text = text;
  file.output = output;
  file.follows = follows;
}

bool CommandFiles::same(const File& a, const File& b) {
  if (a.path == b.path) return true;
  // Outputs are first written as *.partial; an existing file of that name is taken as left by a killed run and
  // overwritten.
  if (a.output && !b.output && b.path == a.path + ".partial") return true;
  if (a.node == b.node && a.node.second != 0) return true;
  return (a.output && is_filter_of(a.path, b.path)) || (b.output && is_filter_of(b.path, a.path));
}

std::string CommandFiles::what(const File& file) {
  return file.follows ? fmt::format("{} (writes {})", file.option, file.path) : file.option;
}

void CommandFiles::take(const CLI::App& command) {
  files_.clear();
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& text : option->results()) {
      if (option->get_type_name() == kOutputFile) {
        if (text.empty()) throw Error(option->get_name(), "", "must name a file");
        const std::vector<std::string> paths = written(command, *option, text);
        for (const std::string& path : paths) {
          const bool named = path == text || (&path == paths.data() && option->get_name() == "--heatmap");
          add(*option, text, path, true, !named);
        }
      } else if (option->get_type_name() == kInputFile ||
                 (option->get_type_name() == kMachineType && text.ends_with(".toml"))) {
        add(*option, text, text, false, false);
      }
    }
  }
  for (const File& a : files_) {
    std::error_code unknown;
    if (!a.output || fs::is_character_file(a.path, unknown)) continue;  // /dev/null may be used repeatedly
    for (const File& b : files_) {
      if (&a == &b || !same(a, b)) continue;
      const std::string rule = b.output ? "two outputs have one name: " : "is an input, too, and would be lost: ";
      throw Error(what(a), a.text, rule + what(b));
    }
  }
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_type_name() != kOutputFile) continue;
    for (const std::string& text : option->results()) {
      require_writable(command, option->get_name() == "--heatmap" ? experiment::heatmap_path(text) : text);
    }
  }
}

void CommandFiles::check(const std::string& read) const {
  const File input = file_of(read);
  for (const File& file : files_) {
    if (file.output && same(file, input)) {
      throw Error(what(file), file.text, "is an input, too, and would be lost: " + read);
    }
  }
}

void CommandFiles::check(const FilesRead& read) const {
  for (const FilesRead::File& file : read.files()) check(file.path);
}

}  // namespace grtx::apps
