// Pieces that several commands' command lines share.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "grtx/apps/grtx/command_files.h"
#include "grtx/apps/grtx/commands.h"
#include "grtx/base/declare/named_enum.h"
#include "grtx/base/files_read.h"
#include "grtx/base/wrapped.h"
#include "grtx/frontend/camera/camera.h"

namespace grtx::sim {

/// A subcommand with --quiet, --help, and defaults shown for every option. `body` runs after parsing and returns the
/// exit code (0 or 1); it may throw grtx::Error for bad input.
CLI::App* make_command(CLI::App& app, CommonOptions& common, const std::string& name, const std::string& description,
                       std::function<int()> body);

/// Prints a sentence, on lines of a terminal's width.
template <typename... Values>
void say(fmt::format_string<Values...> form, Values&&... values) {
  fmt::print("{}\n", wrapped(fmt::format(form, std::forward<Values>(values)...)));
}

/// Accepts only `names`; the message for any other value names the nearest one.
CLI::Validator one_of(std::vector<std::string> names);

/// Accepts numbers from low to high; NaN is left to the check of all options. CLI11's own check says it in other words
/// in each version.
template <typename Number>
CLI::Validator in_range(Number low, Number high) {
  const std::string range = fmt::format("{:.10g} to {:.10g}", static_cast<double>(low), static_cast<double>(high));
  return CLI::Validator(
      [=](std::string& text) -> std::string {
        Number value{};
        if (CLI::detail::lexical_cast(text, value) && !(value < low || value > high)) return {};
        return fmt::format("must be {}, not {}", range, text);
      },
      range);
}

/// An option that takes the name of one of an enumeration's values; allowed: if there, only of those that it allows.
template <NamedEnum Enum>
CLI::Option* add_choice(CLI::App* command, const std::string& flag, Enum& value, const std::string& description,
                        bool (*allowed)(Enum) = nullptr) {
  std::vector<std::string> names;
  for (const std::string& name : names_of<Enum>()) {
    if (allowed == nullptr || allowed(*from_name<Enum>(name))) names.push_back(name);
  }
  const auto assign = [&value](const std::string& name) { value = *from_name<Enum>(name); };
  return command->add_option_function<std::string>(flag, assign, description)
      ->default_str(std::string(name_of(value)))
      ->check(one_of(std::move(names)));
}

/// Which picture of which camera file.
struct ViewOptions {
  std::string cameras;     ///< file or COLMAP folder
  unsigned view = 0;       ///< index in the file
  std::string views;       ///< A:B: a sequence in place of one view
  unsigned width = 0;      ///< pixels; 0: the file's
  unsigned height = 0;     ///< pixels; 0: the file's
  double fov_scale = 1.0;  ///< factor on the tangent of half the field of view
};
/// --cameras (required), --view, --width, --height, --fov-scale.
void add_view_options(CLI::App* command, ViewOptions& view);
/// --views.
void add_views_option(CLI::App* command, ViewOptions& view);
/// Loads the cameras and applies the options. files: takes what is opened. Throws Error when the view does not exist.
frontend::Camera select_camera(const ViewOptions& view, FilesRead& files);
/// The same of --views, if given: one camera a frame.
std::vector<frontend::Camera> select_cameras(const ViewOptions& view, FilesRead& files);
/// File of a frame of a sequence: `path` with the frame's number before its ending.
std::string frame_path(const std::string& path, std::size_t frame);
/// Names for all frames of --views; `path` alone when that is none.
std::vector<std::string> frame_paths(const std::string& path, const std::string& views);

}  // namespace grtx::sim
