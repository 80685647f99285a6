// SPDX-License-Identifier: Apache-2.0
// The strict resume rule (t_min < t_hit) loses hits tied with the last one of a round. Ray by ray, what the exact rule
// processes and the strict one does not is as much as the tracer counts, for every way to trace.
#include <gtest/gtest.h>

#include "frontend/synth/stress_scenes.h"
#include "frontend/tracer/random_scene.h"
#include "grtx/frontend/tracer/ray_tracer.h"
#include "real_scene_files.h"

namespace grtx::frontend {
namespace {

/// Traces rays one by one, so that counters and entries belong to a ray.
class RayByRay {
 public:
  RayByRay(const Scene& scene, const PreparedGaussians& gaussians, const AccelerationStructure& accel,
           const TracerOptions& options)
      : tracer_(scene, gaussians, accel, options), recorder_(accel.image()) {}

  struct Traced {
    std::vector<std::uint32_t> processed;
    std::uint64_t ties_lost = 0;
  };
  Traced trace(const TraceRay& ray) {
    const std::uint64_t before = tracer_.counters().ties_lost;
    recorder_.begin_group(0, traces::RayKind::primary);
    recorder_.begin_ray(0);
    tracer_.trace(ray, recorder_);
    Traced traced;
    for (const traces::Processed& entry : recorder_.processed()) {
      traced.processed.push_back(entry.gaussian);
    }
    traced.ties_lost = tracer_.counters().ties_lost - before;
    return traced;
  }

 private:
  RayTracer tracer_;
  GroupRecorder recorder_;
};

/// Returns the ties lost. Without early termination both rules walk the whole ray, so nothing else may differ.
std::uint64_t expect_exact_count(const Scene& scene, const Camera& camera, const PreparedGaussians& gaussians,
                                 const AccelerationStructure& accel, TracerOptions options) {
  options.ert = 0.0f;
  options.resume = Resume::exact;
  RayByRay exact(scene, gaussians, accel, options);
  options.resume = Resume::strict;
  RayByRay strict(scene, gaussians, accel, options);
  const glm::vec3 origin(camera.position - scene.offset);
  std::uint64_t lost = 0;
  for (unsigned pixel = 0; pixel < camera.width * camera.height; ++pixel) {
    const TraceRay ray(origin, glm::vec3(camera.direction(pixel % camera.width, pixel / camera.width)));
    const RayByRay::Traced all = exact.trace(ray);
    const RayByRay::Traced some = strict.trace(ray);
    EXPECT_EQ(all.ties_lost, 0u) << "pixel " << pixel;
    EXPECT_EQ(all.processed.size() - some.processed.size(), some.ties_lost) << "pixel " << pixel;
    // What is left keeps its order.
    std::size_t next = 0;
    for (const std::uint32_t id : all.processed) {
      if (next < some.processed.size() && some.processed[next] == id) ++next;
    }
    EXPECT_EQ(next, some.processed.size()) << "pixel " << pixel;
    lost += some.ties_lost;
  }
  return lost;
}

TEST(StrictTies, CountedExactlyOnTheTiesPreset) {
  const test::GeneratedScene ties = test::generated_scene("stress-ties", 1500);
  const Camera camera = test::small_view(ties, 0, 16);
  const PreparedGaussians gaussians(ties.scene, true);
  for (const AccelKind kind : {AccelKind::tri20, AccelKind::tlas_tri20, AccelKind::ellipsoid, AccelKind::tlas_sphere}) {
    const AccelerationStructure accel(gaussians, {kind, 6, false});
    for (const Tracing tracing : {Tracing::multi, Tracing::single, Tracing::closest}) {
      std::uint64_t lost = 0;
      for (const unsigned k : {1u, 4u, 8u, 37u}) {
        if (tracing == Tracing::closest && k != 1) continue;
        TracerOptions options;
        options.k = k;
        options.tracing = tracing;
        lost += expect_exact_count(ties.scene, camera, gaussians, accel, options);
      }
      EXPECT_GT(lost, 0u) << accel_name(kind);
    }
  }
}

// With checkpointing ties wait in the eviction buffer and are lost only with it, when the checkpoint buffer overflows.
TEST(StrictTies, CountedExactlyWithCheckpointing) {
  const test::GeneratedScene ties = test::generated_scene("stress-ties", 1500);
  const Camera camera = test::small_view(ties, 0, 16);
  const PreparedGaussians gaussians(ties.scene, true);
  for (const AccelKind kind : {AccelKind::tri20, AccelKind::tlas_tri20}) {
    const AccelerationStructure accel(gaussians, {kind, 6, false});
    for (const unsigned capacity : {1u, 4u, 16u, 1024u}) {
      for (const ReplayTmax replay : {ReplayTmax::infinity, ReplayTmax::kth}) {
        for (const unsigned k : {1u, 4u, 8u}) {
          TracerOptions options;
          options.k = k;
          options.checkpoint = true;
          options.checkpoint_capacity = capacity;
          options.replay_tmax = replay;
          const std::uint64_t lost = expect_exact_count(ties.scene, camera, gaussians, accel, options);
          if (capacity == 1024) {
            EXPECT_EQ(lost, 0u);
          } else if (capacity == 1) {
            EXPECT_GT(lost, 0u);
          }
        }
      }
    }
  }
}

TEST(StrictTies, CountedExactlyOnATrainedScene) {
  const std::string path = test::real_scene_path("statue_st-peter_sh0");
  const std::string cameras = test::real_cameras_path("st-peter");
  if (path.empty() || cameras.empty()) GTEST_SKIP() << "statue_st-peter_sh0.ply or its cameras are missing";
  const Scene scene = load_scene(path);
  const PreparedGaussians gaussians(scene, true);
  const AccelerationStructure accel(gaussians, {AccelKind::tlas_tri20, 6, false});
  for (const unsigned k : {1u, 8u}) {
    TracerOptions options;
    options.k = k;
    expect_exact_count(scene, load_cameras(cameras)[0].resized(12, 12), gaussians, accel, options);
  }
}

}  // namespace
}  // namespace grtx::frontend
