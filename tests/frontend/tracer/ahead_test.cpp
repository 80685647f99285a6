// SPDX-License-Identifier: Apache-2.0
// Several nodes of a ray under way at once: what that changes in work, and that it changes nothing in the image.
#include <gtest/gtest.h>

#include <string>

#include "frontend/synth/stress_scenes.h"
#include "frontend/tracer/random_scene.h"
#include "frontend/tracer/render_helpers.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/traces/check.h"
#include "grtx/traces/reader.h"
#include "grtx/traces/writer.h"
#include "traces/temporary_file.h"

namespace grtx::frontend {
namespace {

constexpr AccelKind kOneLevel[] = {AccelKind::tri20, AccelKind::ellipsoid, AccelKind::box};

void expect_same_image(const RenderResult& expected, const RenderResult& actual, const std::string& what) {
  EXPECT_TRUE(compare(expected.image, actual.image).identical()) << what;
  EXPECT_TRUE(expected.sequences == actual.sequences) << what;
  EXPECT_EQ(expected.counters.rounds, actual.counters.rounds) << what;
  EXPECT_EQ(expected.counters.blended, actual.counters.blended) << what;
}

TEST(Ahead, ImagesAndRoundsAreThoseOfOneNodeAtATimeAndVisitsRise) {
  for (const char* preset : {"hall", "object", "stress-ties", "stress-copies"}) {
    const test::GeneratedScene generated = test::generated_scene(preset, preset[0] == 's' ? 80 : 300, 0);
    const Camera camera = test::small_view(generated, 0, 8);
    const PreparedGaussians gaussians(generated.scene, true);
    unsigned variant = 0;
    for (const AccelKind kind : kOneLevel) {
      const AccelerationStructure accel(gaussians, {kind, 6, false});
      for (const unsigned k : {1u, 4u, 16u}) {
        TracerOptions options;
        options.k = k;
        options.child_order = static_cast<ChildOrder>(variant % 3);
        options.sort_key = variant % 2 == 0 ? SortKey::entry : SortKey::peak;
        options.tmax_update = variant++ % 4 < 2 ? TmaxUpdate::kth : TmaxUpdate::reported;
        const RenderResult one = test::trace_scene(generated.scene, camera, accel, gaussians, options);
        for (const unsigned ahead : {2u, 8u, 32u}) {
          options.ahead = ahead;
          const RenderResult many = test::trace_scene(generated.scene, camera, accel, gaussians, options);
          const std::string what = std::string(preset) + " " + accel_name(kind) + " k " + std::to_string(k) +
                                   " ahead " + std::to_string(ahead);
          expect_same_image(one, many, what);
          EXPECT_GE(many.counters.visits() * 100, one.counters.visits() * 98) << what;
        }
      }
    }
  }
}

TEST(Ahead, TracesAreDepthFirstAndPassTheCheck) {
  const test::GeneratedScene generated = test::generated_scene("hall", 400, 0);
  const Camera camera = test::small_view(generated, 0, 16);
  const PreparedGaussians gaussians(generated.scene, true);
  RenderOptions render;
  render.threads = 2;
  for (const AccelKind kind : kOneLevel) {
    const AccelerationStructure accel(gaussians, {kind, 6, false});
    std::uint64_t visits = 0;
    for (const unsigned ahead : {1u, 3u, 8u}) {
      TracerOptions options;
      options.k = 4;
      options.ahead = ahead;
      const traces::testing::TemporaryFile file("ahead");
      const traces::Header header = trace_header(generated.scene, camera, accel, options, render);
      EXPECT_EQ(header.ahead, ahead);
      traces::Writer writer(file.path(), header);
      const RenderResult result =
          frontend::render({generated.scene, gaussians, accel}, camera, options, render, &writer);
      writer.finish();
      const traces::Reader reader(file.path());
      EXPECT_EQ(traces::check(reader, true), reader.totals());
      EXPECT_EQ(reader.totals().visits(), result.counters.visits());
      EXPECT_GE(reader.totals().visits(), visits) << "t_max comes later";
      visits = reader.totals().visits();
    }
  }
}

}  // namespace
}  // namespace grtx::frontend
