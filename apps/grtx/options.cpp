#include "grtx/apps/grtx/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
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

}  // namespace

CLI::App* make_command(CLI::App& app, CommonOptions& common, const std::string& name, const std::string& description,
                       std::function<int()> body) {
  CLI::App* command = app.add_subcommand(name, description);
  command->option_defaults()->always_capture_default();
  command->add_flag(
      "--quiet", common.quiet,
      "No progress, and no text but errors, warnings and what the command is asked to print (default: off)");
  command->add_flag("--json", common.json, json_help(name));
  command->callback([&common, command, body = std::move(body)] {
    refuse_nan(*command);
    common.files.take(*command);
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

constexpr std::uint64_t kMostFrames = 4096;  ///< whose names are compared with others

struct ViewRange {
  std::uint64_t first = 0, last = 0;
};

/// The views of "A:B", as --views takes them; nothing when the text has another form.
std::optional<ViewRange> view_range(const std::string& views) {
  static const std::regex form("([0-9]{1,9}):([0-9]{1,9})");
  std::smatch match;
  if (!std::regex_match(views, match, form)) return std::nullopt;
  return ViewRange{std::stoul(match[1]), std::stoul(match[2])};
}

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

frontend::Camera select_camera(const ViewOptions& view, FilesRead& files) {
  return adjusted(view, frontend::load_cameras(view.cameras, files), view.view);
}

std::vector<frontend::Camera> select_cameras(const ViewOptions& view, FilesRead& files) {
  if (view.views.empty()) return {select_camera(view, files)};
  const std::optional<ViewRange> range = view_range(view.views);
  if (!range) throw Error("--views", view.views, "must be A:B, two views");
  if (range->first > range->last) throw Error("--views", view.views, "the first view must not lie behind the last");
  const std::vector<frontend::Camera> cameras = frontend::load_cameras(view.cameras, files);
  std::vector<frontend::Camera> chosen;
  for (std::uint64_t i = range->first; i <= range->last; ++i) chosen.push_back(adjusted(view, cameras, i));
  return chosen;
}

std::string frame_path(const std::string& path, std::size_t frame) {
  const std::filesystem::path name(path);
  return (name.parent_path() / fmt::format("{}_{}{}", name.stem().string(), frame, name.extension().string())).string();
}

std::vector<std::string> frame_paths(const std::string& path, const std::string& views) {
  const std::optional<ViewRange> range = view_range(views);
  if (!range || range->first >= range->last) return {path};
  std::vector<std::string> paths;
  const std::uint64_t frames = std::min(range->last - range->first + 1, kMostFrames);
  for (std::uint64_t i = 0; i < frames; ++i) paths.push_back(frame_path(path, i));
  return paths;
}

}  // namespace grtx::sim
