#include "grtx/apps/grtx/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <regex>
#include <utility>

#include "grtx/apps/grtx/json_output.h"
#include "grtx/base/error.h"
#include "grtx/base/nearest_name.h"

namespace grtx::sim {

namespace {

/// NaN lies in every range and passes every comparison that asks for less.
void refuse_nan(const CLI::App& command) {
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_type_name().find("FLOAT") == std::string::npos) continue;
    for (const std::string& text : option->results()) {
      char* end = nullptr;
      if (std::isnan(std::strtod(text.c_str(), &end))) throw Error(option->get_name(), text, "must be a number");
    }
  }
}

struct NamedFile {
  std::string option, text, path;
  bool output = false;
};

/// What the options of kind kInputFile and kOutputFile were given; a heat map's as NAME=FILE.
std::vector<NamedFile> named_files(const CLI::App& command) {
  std::vector<NamedFile> files;
  for (const CLI::Option* option : command.get_options()) {
    const bool output = option->get_type_name() == kOutputFile;
    if (!output && option->get_type_name() != kInputFile) continue;
    for (const std::string& text : option->results()) {
      const std::size_t equals = option->get_name() == "--heatmap" ? text.find('=') : text.npos;
      const std::string name = equals == text.npos ? text : text.substr(equals + 1);
      std::error_code unknown;
      const std::filesystem::path path = std::filesystem::weakly_canonical(name, unknown);
      files.push_back({option->get_name(), text, unknown ? name : path.string(), output});
    }
  }
  return files;
}

void refuse_overwriting(const CLI::App& command) {
  const std::vector<NamedFile> files = named_files(command);
  for (const NamedFile& file : files) {
    if (file.output && file.text.empty()) throw Error(file.option, "", "must name a file");
  }
  for (const NamedFile& a : files) {
    std::error_code unknown;
    if (!a.output || std::filesystem::is_character_file(a.path, unknown)) continue;  // /dev/null takes all
    for (const NamedFile& b : files) {
      if (&a == &b || a.path != b.path) continue;
      throw Error(
          a.option, a.text,
          b.output ? "two outputs have one name: " + b.option : "is an input, too, and would be lost: " + b.option);
    }
  }
}

}  // namespace

CLI::App* make_command(CLI::App& app, CommonOptions& common, const std::string& name, const std::string& description,
                       std::function<int()> body) {
  CLI::App* command = app.add_subcommand(name, description);
  command->option_defaults()->always_capture_default();
  command->add_flag("--quiet", common.quiet, "No progress and no informative text (default: off)");
  command->add_flag("--json", common.json, json_help(name));
  command->callback([&common, command, body = std::move(body)] {
    refuse_nan(*command);
    refuse_overwriting(*command);
    common.action = body;
  });
  return command;
}

CLI::Validator one_of(std::vector<std::string> names) {
  const std::string choices = joined_names(names);
  return CLI::Validator(
      [names = std::move(names), choices](std::string& value) -> std::string {
        if (std::find(names.begin(), names.end(), value) != names.end()) return {};
        return fmt::format("unknown value '{}', the nearest is '{}' (known: {})", value, nearest_name(value, names),
                           choices);
      },
      "{" + choices + "}");
}

void add_view_options(CLI::App* command, ViewOptions& view) {
  command
      ->add_option("--cameras", view.cameras, "3DGS cameras.json, NeRF transforms.json or COLMAP folder (no default)")
      ->type_name(kInputFile)
      ->required();
  command->add_option("--view", view.view, "Index of the view in the camera file");
  command->add_option("--width", view.width, "Image width in pixels; 0 takes the camera's")
      ->check(in_range(0U, 65536U));
  command->add_option("--height", view.height, "Image height in pixels; 0 takes the camera's")
      ->check(in_range(0U, 65536U));
  command->add_option("--fov-scale", view.fov_scale, "Factor on the tangent of half the field of view")
      ->check(in_range(1e-3, 1e3));
}

void add_views_option(CLI::App* command, ViewOptions& view) {
  command
      ->add_option("--views", view.views,
                   "Views A:B, both included, as the frames of a sequence in one trace: caches stay warm from frame to "
                   "frame (default: one view)")
      ->excludes("--view");
}

namespace {

/// One of the views of `view.cameras`, with the options applied.
frontend::Camera adjusted(const ViewOptions& view, const std::vector<frontend::Camera>& cameras, std::uint64_t index) {
  const std::string place = fmt::format("view {}", index);
  if (index >= cameras.size()) {
    throw Error(view.cameras, place,
                cameras.empty() ? std::string("the file has no views")
                                : fmt::format("the file has {} views, 0 to {}", cameras.size(), cameras.size() - 1));
  }
  frontend::Camera camera = cameras[index];
  const unsigned width = view.width == 0 ? camera.width : view.width;
  const unsigned height = view.height == 0 ? camera.height : view.height;
  if (width == 0 || height == 0) {
    throw Error(view.cameras, place, "the camera has no resolution: give --width and --height");
  }
  if (width != camera.width || height != camera.height) camera = camera.resized(width, height);
  if (view.fov_scale != 1.0) camera = camera.fov_scaled(view.fov_scale);
  return camera;
}

}  // namespace

frontend::Camera select_camera(const ViewOptions& view) {
  return adjusted(view, frontend::load_cameras(view.cameras), view.view);
}

std::vector<frontend::Camera> select_cameras(const ViewOptions& view) {
  if (view.views.empty()) return {select_camera(view)};
  static const std::regex form("([0-9]{1,9}):([0-9]{1,9})");
  std::smatch match;
  if (!std::regex_match(view.views, match, form)) throw Error("--views", view.views, "must be A:B, two views");
  const std::uint64_t first = std::stoul(match[1]);
  const std::uint64_t last = std::stoul(match[2]);
  if (first > last) throw Error("--views", view.views, "the first view must not lie behind the last");
  const std::vector<frontend::Camera> cameras = frontend::load_cameras(view.cameras);
  std::vector<frontend::Camera> chosen;
  for (std::uint64_t i = first; i <= last; ++i) chosen.push_back(adjusted(view, cameras, i));
  return chosen;
}

std::string frame_path(const std::string& path, std::size_t frame) {
  const std::filesystem::path name(path);
  return (name.parent_path() / fmt::format("{}_{}{}", name.stem().string(), frame, name.extension().string())).string();
}

}  // namespace grtx::sim
