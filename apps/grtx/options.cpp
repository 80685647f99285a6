#include "grtx/apps/grtx/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "grtx/base/error.h"
#include "grtx/base/nearest_name.h"

namespace grtx::sim {

CLI::App* make_command(CLI::App& app, CommonOptions& common, const std::string& name, const std::string& description,
                       std::function<int()> body) {
  CLI::App* command = app.add_subcommand(name, description);
  command->option_defaults()->always_capture_default();
  command->add_flag("--quiet", common.quiet, "No progress and no informative text (default: off)");
  command->callback([&common, body = std::move(body)] { common.action = body; });
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
      ->required();
  command->add_option("--view", view.view, "Index of the view in the camera file");
  command->add_option("--width", view.width, "Image width in pixels; 0 takes the camera's")
      ->check(CLI::Range(0U, 65536U));
  command->add_option("--height", view.height, "Image height in pixels; 0 takes the camera's")
      ->check(CLI::Range(0U, 65536U));
  command->add_option("--fov-scale", view.fov_scale, "Factor on the tangent of half the field of view")
      ->check(CLI::Range(1e-3, 1e3));
}

frontend::Camera select_camera(const ViewOptions& view) {
  const std::vector<frontend::Camera> cameras = frontend::load_cameras(view.cameras);
  if (view.view >= cameras.size()) {
    throw Error(view.cameras, fmt::format("view {}", view.view),
                cameras.empty() ? std::string("the file has no views")
                                : fmt::format("the file has {} views, 0 to {}", cameras.size(), cameras.size() - 1));
  }
  frontend::Camera camera = cameras[view.view];
  const unsigned width = view.width == 0 ? camera.width : view.width;
  const unsigned height = view.height == 0 ? camera.height : view.height;
  if (width == 0 || height == 0) {
    throw Error(view.cameras, fmt::format("view {}", view.view),
                "the camera has no resolution: give --width and --height");
  }
  if (width != camera.width || height != camera.height) camera = camera.resized(width, height);
  if (view.fov_scale != 1.0) camera = camera.fov_scaled(view.fov_scale);
  return camera;
}

}  // namespace grtx::sim
