#include "grtx/apps/grtx/object_scene.h"

#include <fmt/format.h>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/scene/scene_io.h"
#include "grtx/frontend/tracer/multi_object_render.h"
#include "grtx/modules/kernel/statistics.h"
#include "grtx/rtl_tlm/run/statistics_json.h"

namespace grtx::sim {

LoadedObjects load_objects(const std::string& path) {
  const frontend::ObjectList list = frontend::load_object_list(path);
  LoadedObjects objects;
  for (const std::string& file : list.files) objects.scenes.push_back(frontend::load_scene(file));
  objects.placements = list.placements;
  return objects;
}

void refuse_objects(const std::string& path, const std::string& command) {
  if (!frontend::is_object_list(path)) return;
  throw Error(path, command, "traces hold one level of instances: object lists need grtx trace --no-trace");
}

int render_object_list(const std::string& scene, const frontend::Camera& camera, frontend::AccelKind accel,
                       const TracerCli& cli, bool checkpoint, const std::string& image, const std::string& statistics,
                       bool quiet) {
  if (cli.secondary.what != "none") throw Error(scene, "--secondary", "works on scenes of one object");
  if (cli.tracing != name_of(frontend::Tracing::multi))
    throw Error(scene, "--tracing", "works on scenes of one object, but for multi");
  if (cli.triangle_test == frontend::TriangleTest::world)
    throw Error(scene, "--triangle-test world", "works on scenes of one object");
  const frontend::TracerOptions tracer = tracer_options(cli, checkpoint, accel);
  LoadedObjects loaded = load_objects(scene);
  std::map<std::string, std::string> inputs = {{"scene", scene}, {"camera", camera.name}};
  for (std::size_t i = 0; i < loaded.scenes.size(); ++i) {
    inputs[fmt::format("object_hash.{}", i)] = loaded.scenes[i].hash;
  }
  const frontend::MultiObjectWorld world(std::move(loaded.scenes), loaded.placements, accel_options(cli, accel),
                                         tracer.kernel);
  const frontend::RenderResult result = frontend::render_objects(world, camera, tracer, render_options(cli, quiet));
  if (!image.empty()) frontend::write_image(image, result.image);
  const frontend::TracerCounters& c = result.counters;
  if (!statistics.empty()) {
    modules::StatisticList list, host;
    list.add("tracer.rays", c.rays, "rays", "rays traced");
    list.add("tracer.rounds", c.rounds, "rounds", "traceRay calls, summed over rays");
    list.add("tracer.visits.internal", c.visits_internal, "visits", "internal nodes of all levels");
    list.add("tracer.visits.instance", c.visits_instance, "visits", "instance leaves of scene and objects");
    list.add("tracer.visits.leaf", c.visits_leaf, "visits", "primitive leaves processed");
    list.add("tracer.visits.total", c.visits(), "visits", "nodes processed, all kinds");
    list.add("tracer.checkpoint.written", c.checkpoints_written, "entries", "checkpoint entries written");
    list.add("tracer.checkpoint.read", c.checkpoints_read, "entries", "checkpoint entries read");
    list.add("tracer.blended", c.blended, "hits", "hits blended into a pixel");
    list.add("accel.bytes", world.image().size(), "B", "node image: scene TLAS, TLAS of each file, shared BLAS");
    list.add("accel.scene_tlas_bytes", world.scene_tlas_bytes(), "B", "set aside for the scene TLAS");
    list.add("accel.objects", std::uint64_t{world.placed().size()}, "objects", "placements");
    list.add("accel.files", std::uint64_t{world.objects().size()}, "files", "TLASes of objects");
    list.add("accel.gaussians", world.gaussians(), "Gaussians", "of all placements");
    host.add("tracer.wall_seconds", result.seconds, "s", "host time of tracing alone");
    host.add("accel.build_seconds", world.build_seconds(), "s", "host time of building all structures");
    nlohmann::ordered_json config;
    for (const auto& [name, value] : option_inputs(cli, checkpoint, accel)) config[name] = value;
    write_file(statistics, statistics_text(statistics_document(config, inputs, list, host)));
  }
  if (!quiet) {
    fmt::print(
        "{} objects of {} files: {} rays, {} rounds, {} visits, {} blended; {} B of nodes, {} of them scene TLAS\n",
        world.placed().size(), world.objects().size(), c.rays, c.rounds, c.visits(), c.blended, world.image().size(),
        world.scene_tlas_bytes());
  }
  return 0;
}

}  // namespace grtx::sim
