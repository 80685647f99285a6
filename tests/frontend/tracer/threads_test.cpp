// SPDX-License-Identifier: Apache-2.0
// Neither threads nor what the tracer leaves out change an image or a trace.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "frontend/tracer/random_scene.h"
#include "frontend/tracer/render_helpers.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/frontend/tracer/tracer.h"

namespace grtx::frontend {
namespace {

/// Some Gaussians can never count, some rays miss all, some rays end early.
Scene scene_with_everything() {
  Scene scene = test::random_scene(77, {300, 0.7, -2.0, 0.3, 0.0005, 0.99, 1});
  for (std::size_t i = 3; i < scene.size(); i += 5) scene.opacity[i] = 0.99f;
  for (std::size_t i = 0; i < scene.size(); i += 7) {
    scene.opacity[i] = 0.0030f;
    scene.scale[i] *= 4.0f;
  }
  return scene;
}

std::vector<std::uint64_t> work(const TracerCounters& c) {
  return {c.rays,
          c.rounds,
          c.visits_internal,
          c.visits_instance,
          c.visits_leaf,
          c.any_hit_inserted,
          c.any_hit_evicted,
          c.any_hit_rejected,
          c.any_hit_ignored,
          c.checkpoints_written,
          c.checkpoints_read,
          c.processed,
          c.blended,
          c.inside_skipped,
          c.terminated};
}

std::string traced_bytes(const Scene& scene, const Camera& camera, AccelKind kind, const TracerOptions& options,
                         unsigned threads = 1) {
  const PreparedGaussians gaussians(scene, true);
  const AccelerationStructure accel(gaussians, {kind, 6, false});
  RenderOptions render{.threads = threads};
  const std::string path =
      (std::filesystem::temp_directory_path() / ("threads_test_" + std::to_string(::getpid()) + ".grtx")).string();
  traces::Writer writer(path, trace_header(scene, camera, accel, options, render));
  frontend::render(scene, gaussians, accel, camera, options, render, &writer);
  writer.finish();
  std::string bytes = read_file(path);
  std::filesystem::remove(path);
  return bytes;
}

// The canonical hit function finds at an instance leaf what a walk of the BLAS finds (docs/model/tracer.md).
TEST(WithoutWalksOfTheBlas, ImagesAreTheSameAndATraceIsRefused) {
  const Scene scene = scene_with_everything();
  const Camera camera = test::front_camera(28, 28, 6.0);
  for (const AccelKind kind : {AccelKind::tri20, AccelKind::ellipsoid, AccelKind::tlas_tri20, AccelKind::tlas_sphere}) {
    for (const bool checkpoint : {false, true}) {
      for (const SortKey key : {SortKey::entry, SortKey::peak}) {
        SCOPED_TRACE(accel_name(kind));
        TracerOptions options;
        options.k = 4;
        options.checkpoint = checkpoint;
        options.sort_key = key;
        options.sh_direction = checkpoint ? ShDirection::centre : ShDirection::ray;
        const RenderResult expected = test::trace_scene(scene, camera, kind, options);
        ASSERT_GT(expected.counters.terminated, 20u);
        EXPECT_GT(expected.counters.skipped_dead_colours, 0u);
        EXPECT_GT(expected.counters.skipped_sh_bands, 0u);
        EXPECT_GT(expected.counters.skipped_scene_misses, 0u);
        EXPECT_GT(expected.counters.skipped_events, 0u);
        options.walk_blas = false;
        const RenderResult got = test::trace_scene(scene, camera, kind, options);
        EXPECT_EQ(got.image.pixels, expected.image.pixels);
        EXPECT_EQ(got.sequences, expected.sequences);
        EXPECT_EQ(got.counters.blended, expected.counters.blended);
        EXPECT_EQ(got.counters.visits() < expected.counters.visits(), is_two_level(kind));
        EXPECT_THROW(traced_bytes(scene, camera, kind, options), std::logic_error);
      }
    }
  }
}

TEST(Threads, ChangeNoByteOfImageOrTrace) {
  const Scene scene = scene_with_everything();
  const Camera camera = test::front_camera(40, 24, 3.0);
  for (const AccelKind kind : {AccelKind::tri20, AccelKind::tlas_tri20}) {
    TracerOptions options;
    options.checkpoint = kind == AccelKind::tlas_tri20;
    const PreparedGaussians gaussians(scene, true);
    const AccelerationStructure accel(gaussians, {kind, 6, false});
    RenderOptions render{.threads = 1};
    const RenderResult expected = frontend::render(scene, gaussians, accel, camera, options, render, nullptr);
    const std::string trace = traced_bytes(scene, camera, kind, options, 1);
    for (const unsigned threads : {2u, 7u}) {
      render.threads = threads;
      const RenderResult got = frontend::render(scene, gaussians, accel, camera, options, render, nullptr);
      EXPECT_EQ(got.image.pixels, expected.image.pixels) << threads;
      EXPECT_EQ(work(got.counters), work(expected.counters)) << threads;
      EXPECT_TRUE(traced_bytes(scene, camera, kind, options, threads) == trace) << threads;
    }
  }
}

}  // namespace
}  // namespace grtx::frontend
