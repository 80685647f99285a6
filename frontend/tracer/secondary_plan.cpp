// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/tracer/secondary_plan.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/gaussian/prepared_gaussians.h"
#include "grtx/frontend/tracer/light_path.h"
#include "grtx/frontend/tracer/ray_tracer.h"
#include "grtx/frontend/tracer/tracer.h"

namespace grtx::frontend {
namespace {

struct Found {
  SecondaryRay ray;
  unsigned bounces = 0;
  traces::RayKind kind = traces::RayKind::glass;
};

/// Secondary rays that follow from one group of primary rays.
struct GroupFinds {
  std::vector<Found> rays;
  std::uint64_t truncated = 0;
};

void follow(RayTracer& tracer, LightPath path, std::uint32_t pixel, float ert, GroupFinds& finds) {
  NullRecorder recorder;
  float transmittance = 1.0f;
  while (path.piece().meets_surface()) {
    const PathPiece& piece = path.piece();
    const TraceRay ray{glm::vec3(piece.origin), glm::vec3(piece.direction)};
    transmittance = tracer.trace(ray, recorder, transmittance, static_cast<float>(piece.limit)).transmittance;
    if (transmittance < ert) return;
    if (!path.advance()) break;
    finds.rays.push_back({{pixel, glm::vec3(path.piece().origin), glm::vec3(path.piece().direction),
                           static_cast<float>(path.piece().limit), transmittance},
                          path.bounces(),
                          path.piece().kind});
  }
  if (path.truncated()) ++finds.truncated;
}

}  // namespace

float SecondaryPlan::primary_limit(const glm::vec3& origin, const glm::vec3& direction) const {
  return static_cast<float>(LightPath(objects, glm::dvec3(origin), glm::dvec3(direction)).piece().limit);
}

SecondaryPlan plan_secondary(const Scene& scene, const PreparedGaussians& gaussians, const AccelerationStructure& accel,
                             const Camera& camera, const TracerOptions& options, const OpticalObjects& objects,
                             bool linear_mapping, unsigned threads, unsigned warp_size) {
  SecondaryPlan plan;
  if (objects.empty()) return plan;
  plan.objects = objects.relative_to(scene.offset);
  const glm::vec3 origin(camera.position - scene.offset);
  const auto pixels = map_pixels(camera.width, camera.height, linear_mapping, warp_size);
  std::vector<GroupFinds> finds(pixels.size());
  tbb::enumerable_thread_specific<RayTracer> tracers([&] { return RayTracer(scene, gaussians, accel, options); });
  tbb::task_arena arena(threads == 0 ? tbb::task_arena::automatic : static_cast<int>(threads));
  arena.execute([&] {
    tbb::parallel_for(std::size_t{0}, pixels.size(), [&](std::size_t group) {
      for (const std::uint32_t pixel : pixels[group]) {
        const glm::vec3 direction(camera.direction(pixel % camera.width, pixel / camera.width));
        if (direction == glm::vec3(0.0f)) continue;
        follow(tracers.local(), LightPath(plan.objects, glm::dvec3(origin), glm::dvec3(direction)), pixel, options.ert,
               finds[group]);
      }
    });
  });

  for (const GroupFinds& f : finds) plan.truncated += f.truncated;
  for (unsigned bounces = 1; bounces <= objects.max_bounces; ++bounces) {
    for (const traces::RayKind kind : {traces::RayKind::glass, traces::RayKind::mirror}) {
      const std::size_t begin = plan.rays.size();
      for (const GroupFinds& f : finds) {
        for (const Found& found : f.rays) {
          if (found.bounces == bounces && found.kind == kind) plan.rays.push_back(found.ray);
        }
      }
      for (std::size_t first = begin; first < plan.rays.size(); first += warp_size) {
        const std::size_t count = std::min<std::size_t>(warp_size, plan.rays.size() - first);
        plan.groups.push_back({kind, static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(count)});
      }
    }
  }
  return plan;
}

}  // namespace grtx::frontend
