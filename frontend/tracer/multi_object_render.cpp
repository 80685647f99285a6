#include "grtx/frontend/tracer/multi_object_render.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <chrono>

#include "grtx/base/progress.h"
#include "grtx/frontend/tracer/ray_tracer.h"

namespace grtx::frontend {

RenderResult render_objects(const MultiObjectWorld& world, const Camera& camera, const TracerOptions& options,
                            const RenderOptions& render) {
  RenderResult result;
  result.image = Image(camera.width, camera.height);
  if (render.keep_sequences) result.sequences.resize(result.image.pixels.size());
  const auto groups = map_pixels(camera.width, camera.height, render.linear_mapping, render.warp_size);
  const glm::vec3 origin(camera.position - world.offset());
  Progress progress("tracing objects", result.image.pixels.size(), " rays", render.quiet);
  tbb::enumerable_thread_specific<RayTracer> tracers([&] { return RayTracer(world, options); });
  const auto start = std::chrono::steady_clock::now();
  tbb::task_arena arena(render.threads == 0 ? tbb::task_arena::automatic : static_cast<int>(render.threads));
  arena.execute([&] {
    tbb::parallel_for(std::size_t{0}, groups.size(), [&](std::size_t group) {
      RayTracer& tracer = tracers.local();
      NullRecorder recorder;
      for (const std::uint32_t pixel : groups[group]) {
        const glm::dvec3 direction = camera.direction(pixel % camera.width, pixel / camera.width);
        if (direction == glm::dvec3(0.0)) continue;
        if (render.keep_sequences) tracer.collect_blended(&result.sequences[pixel]);
        result.image.pixels[pixel] = tracer.trace(TraceRay(origin, glm::vec3(direction)), recorder).colour;
      }
      progress.add(groups[group].size());
    });
  });
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  progress.finish();
  for (const RayTracer& tracer : tracers) result.counters.add(tracer.counters());
  return result;
}

}  // namespace grtx::frontend
