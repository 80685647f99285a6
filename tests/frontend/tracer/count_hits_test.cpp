// SPDX-License-Identifier: Apache-2.0
// What lies behind the ends of rays: all proxy hits against a brute-force count.
#include <gtest/gtest.h>

#include <limits>

#include "frontend/tracer/random_scene.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/tracer/tracer.h"

namespace grtx::frontend {
namespace {

/// Every Gaussian against every ray.
std::uint64_t hits_by_hand(const PreparedGaussians& gaussians, std::size_t count, const Proxy& proxy,
                           const Camera& camera) {
  std::uint64_t hits = 0;
  for (std::uint32_t pixel = 0; pixel < camera.width * camera.height; ++pixel) {
    const TraceRay ray(glm::vec3(camera.position),
                       glm::vec3(camera.direction(pixel % camera.width, pixel / camera.width)));
    for (std::uint32_t g = 0; g < count; ++g) {
      const Hit hit = canonical_hit(ray, to_unit_ray(ray, gaussians.record(g)), gaussians, g, proxy, SortKey::entry,
                                    InsideRule::skip, face_test(SimdPath::portable));
      hits += hit.kind == HitKind::hit ? 1 : 0;
    }
  }
  return hits;
}

TEST(CountHits, CountsWhatEveryRayMeetsHoweverItIsTraced) {
  const Scene scene = test::random_scene(14, {.count = 300, .log_scale_mean = -1.6, .opacity_high = 0.99});
  const PreparedGaussians gaussians(scene, true);
  const Camera camera = test::front_camera(12, 8, 1.5);
  for (const AccelKind kind : {AccelKind::tri20, AccelKind::tlas_tri20, AccelKind::tlas_sphere}) {
    const AccelerationStructure accel(gaussians, {kind, 6, false});
    const std::uint64_t expected = hits_by_hand(gaussians, scene.size(), accel.proxy(), camera);
    for (const bool checkpoint : {false, true}) {
      for (const unsigned k : {1u, 8u}) {
        TracerOptions options;
        options.k = k;
        options.checkpoint = checkpoint;
        options.ert = 0.05f;
        RenderOptions render{.threads = 1, .count_hits = true};
        const RenderResult result = frontend::render(scene, gaussians, accel, camera, options, render, nullptr);
        ASSERT_TRUE(result.counters.hits.has_value());
        EXPECT_EQ(*result.counters.hits, expected) << accel_name(kind) << " k " << k;
        EXPECT_GT(result.counters.terminated, 0u);
        EXPECT_LT(result.counters.processed, *result.counters.hits) << "rays end before their last hit";
      }
    }
    TracerOptions options;
    options.ert = 0.0f;
    RenderOptions render{.threads = 1};
    const RenderResult whole = frontend::render(scene, gaussians, accel, camera, options, render, nullptr);
    EXPECT_EQ(whole.counters.processed, expected) << "without early termination all are processed";
    EXPECT_FALSE(whole.counters.hits.has_value());
  }
}

TEST(TracerCounters, NoneIsForgottenInTheTable) { EXPECT_EQ(TracerCounters::table().bytes(), sizeof(TracerCounters)); }

}  // namespace
}  // namespace grtx::frontend
