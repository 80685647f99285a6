// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/view_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <regex>

#include "grtx/base/error.h"
#include "grtx/base/files_read.h"

namespace grtx::experiment {
namespace {

constexpr std::uint64_t kMostFrames = 4096;  ///< limit on file names that frame_paths() lists

struct ViewRange {
  std::uint64_t first = 0, last = 0;
};

/// The views of "A:B", as --views takes them; nullopt if the text has another form.
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

}  // namespace grtx::experiment
