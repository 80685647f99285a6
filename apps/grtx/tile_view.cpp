#include "grtx/apps/grtx/tile_view.h"

#include <fmt/format.h>

#include <algorithm>

#include "grtx/apps/grtx/json_output.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/scene/scene_io.h"
#include "grtx/frontend/tiles/tile_tracer.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/rtl_tlm/run/statistics_json.h"

namespace grtx::sim {
namespace {

/// Those of --tracing multi, whose image this is.
frontend::TracerOptions tile_options(TracerCli cli, frontend::AccelKind accel) {
  cli.tracing = name_of(frontend::Tracing::multi);
  const frontend::TracerOptions options = tracer_options(cli, false, accel);
  frontend::check_tile_options(options);
  return options;
}

}  // namespace

int render_tile_view(const std::string& scene_file, const ViewOptions& view, frontend::AccelKind accel,
                     const TracerCli& cli, const std::string& image, const std::string& statistics,
                     const CommonOptions& common) {
  const frontend::TracerOptions options = tile_options(cli, accel);
  FilesRead files;
  const frontend::Camera camera = select_camera(view, files);
  const frontend::Scene scene = frontend::load_scene(scene_file, {}, files);
  common.files.check(files);
  if (!optical_objects(cli.secondary, scene, camera).empty()) {
    throw Error("--tracing", "tiles", "traces camera rays only: glass and mirrors need --tracing multi");
  }
  const frontend::PreparedGaussians gaussians(scene, options.kernel);
  const frontend::TileStructure structure(scene, gaussians, frontend::proxy_of(accel));
  const frontend::TileResult result =
      frontend::render_tiles(scene, gaussians, structure, camera, options, render_options(cli, common.quiet));
  if (!image.empty()) frontend::write_image(image, result.image);
  const frontend::TileCounters& c = result.counters;
  const double seconds = std::max(result.seconds, 1e-9);
  if (common.json || !statistics.empty()) {
    std::map<std::string, std::string> inputs = option_inputs(cli, false, accel);
    nlohmann::ordered_json config;
    for (const auto& [name, value] : inputs) config[name] = value;
    inputs["scene"] = scene.name;
    inputs["scene_hash"] = scene.hash;
    inputs["camera"] = camera.name;
    inputs.merge(files.inputs());
    modules::StatisticList host;
    host.add("tracer.wall_seconds", result.seconds, "s", "host time of tracing alone");
    host.add("tracer.rays_per_second", static_cast<double>(c.rays) / seconds, "1/s", "rays / wall_seconds");
    host.add("tracer.tiles.build_seconds", structure.total_seconds(), "s", "host time of building the tiles' BVH");
    modules::StatisticList counted;
    frontend::TileCounters::table().describe(c, counted, "tracer");
    const nlohmann::ordered_json document = statistics_document(config, inputs, {}, counted, host);
    if (!statistics.empty()) write_file(statistics, statistics_text(document));
    if (common.json) print_json(document);
  }
  if (!common.quiet && !common.json) {
    fmt::print("tiles of {}: {} rays, {} blended, {:.3g} Mrays/s\n", frontend::accel_name(accel), c.rays, c.blended,
               static_cast<double>(c.rays) / seconds * 1e-6);
  }
  return 0;
}

}  // namespace grtx::sim
