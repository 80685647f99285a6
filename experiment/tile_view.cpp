// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/tile_view.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "grtx/base/error.h"
#include "grtx/base/progress.h"
#include "grtx/frontend/tracer/scene_tracer.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/rtl_tlm/run/statistics_json.h"

namespace grtx::experiment {
namespace {

/// Options of --tracing multi: tile tracing gives the same image.
frontend::TracerOptions tile_options(TracerSettings settings, frontend::AccelKind accel) {
  settings.tracing = name_of(frontend::Tracing::multi);
  const frontend::TracerOptions options = tracer_options(settings, false, accel);
  frontend::check_tile_options(options);
  return options;
}

nlohmann::ordered_json tile_document(const TileView& view, double build_seconds,
                                     std::map<std::string, std::string> inputs,
                                     const std::map<std::string, std::string>& of_scene) {
  nlohmann::ordered_json config;
  for (const auto& [name, value] : inputs) config[name] = value;
  for (const auto& [name, value] : of_scene) inputs[name] = value;
  const frontend::TileCounters& c = view.result.counters;
  modules::StatisticList host;
  host.add("tracer.wall_seconds", view.result.seconds, "s", "host time of tracing alone");
  host.add("tracer.rays_per_second", static_cast<double>(c.rays) / view.seconds, "1/s", "rays / wall_seconds");
  host.add("tracer.tiles.build_seconds", build_seconds, "s", "host time of building the tiles' BVH");
  modules::StatisticList counted;
  frontend::TileCounters::table().describe(c, counted, "tracer");
  return sim::statistics_document(config, inputs, {}, counted, host);
}

}  // namespace

TileView render_tile_view(const std::string& scene_file, const ViewOptions& view, frontend::AccelKind accel,
                          const TracerSettings& settings, bool quiet,
                          const std::function<void(const FilesRead&)>& opened) {
  const frontend::TracerOptions options = tile_options(settings, accel);
  FilesRead files;
  const frontend::Camera camera = select_camera(view, files);
  const frontend::Scene scene = frontend::load_flat_scene(scene_file, files, quiet);
  if (opened) opened(files);
  if (!optical_objects(settings.secondary, scene, camera).empty()) {
    throw Error("--tracing", "tiles", "traces camera rays only: glass and mirrors need --tracing multi");
  }
  std::optional<Progress> progress(std::in_place, "building tiles", 0, "", quiet);
  const frontend::PreparedGaussians gaussians(scene, options.kernel);
  const frontend::TileStructure structure(scene, gaussians, frontend::proxy_of(accel));
  progress.reset();
  TileView rendered;
  rendered.result =
      frontend::render_tiles(scene, gaussians, structure, camera, options, render_options(settings, quiet));
  rendered.seconds = std::max(rendered.result.seconds, 1e-9);
  std::map<std::string, std::string> of_scene = {
      {"scene", scene.name}, {"scene_hash", scene.hash}, {"camera", camera.name}};
  of_scene.merge(files.inputs());
  rendered.document =
      tile_document(rendered, structure.total_seconds(), option_inputs(settings, false, accel), of_scene);
  return rendered;
}

}  // namespace grtx::experiment
