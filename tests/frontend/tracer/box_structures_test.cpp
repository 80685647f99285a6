// SPDX-License-Identifier: Apache-2.0
// Boxes hold what ellipsoids and spheres do, and a shader computes the same hit: the same images, visits and rounds.
#include <gtest/gtest.h>

#include "frontend/tracer/random_scene.h"
#include "frontend/tracer/render_helpers.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/image/image.h"

namespace grtx::frontend {
namespace {

struct Pair {
  AccelKind box, unit;
};

TEST(BoxStructures, GiveTheImagesAndVisitsOfTheUnitThatTestsTheSame) {
  const Scene scene = grtx::test::random_scene(31, {.count = 300, .sh_degree = 1});
  const Camera camera = grtx::test::front_camera(32, 24, 2.0);
  const PreparedGaussians gaussians(scene, Kernel{});
  RenderResult first;
  for (const Pair& pair :
       {Pair{AccelKind::box, AccelKind::ellipsoid}, Pair{AccelKind::tlas_box, AccelKind::tlas_sphere}}) {
    const AccelerationStructure box(gaussians, {pair.box}), unit(gaussians, {pair.unit});
    EXPECT_EQ(box.image().size(), unit.image().size());
    for (const bool checkpoint : {false, true}) {
      for (const Tracing tracing : {Tracing::multi, Tracing::single, Tracing::list}) {
        if (checkpoint && tracing != Tracing::multi) continue;
        TracerOptions options;
        options.k = tracing == Tracing::multi ? 4u : 200u;
        options.checkpoint = checkpoint;
        options.tracing = tracing;
        const RenderResult a = grtx::test::trace_scene(scene, camera, box, gaussians, options);
        const RenderResult b = grtx::test::trace_scene(scene, camera, unit, gaussians, options);
        EXPECT_EQ(compare(a.image, b.image).different_pixels, 0u) << accel_name(pair.box);
        EXPECT_TRUE(a.sequences == b.sequences) << accel_name(pair.box);
        EXPECT_EQ(a.counters.visits_leaf, b.counters.visits_leaf);
        EXPECT_EQ(a.counters.any_hit_calls(), b.counters.any_hit_calls());
        if (first.sequences.empty()) first = a;
        EXPECT_EQ(compare(a.image, first.image).different_pixels, 0u) << "all of them";
      }
    }
  }
  EXPECT_GT(first.counters.blended, 0u);
}

}  // namespace
}  // namespace grtx::frontend
