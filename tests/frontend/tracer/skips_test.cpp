// Skipped work changes no bit of the image; the faithful skips change no counter and no byte of the trace either.
#include "grtx/frontend/tracer/skips.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "frontend/tracer/random_scene.h"
#include "frontend/tracer/render_helpers.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"

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

/// Everything but what the skips themselves count.
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

std::uint64_t counted(const TracerCounters& c, Skip skip) {
  switch (skip) {
    case Skip::retests:
      return c.skipped_retests;
    case Skip::dead_colours:
      return c.skipped_dead_colours;
    case Skip::sh_bands:
      return c.skipped_sh_bands;
    case Skip::scene_miss:
      return c.skipped_scene_misses;
    case Skip::events:
      return c.skipped_events;
    case Skip::never_accepted:
      return c.skipped_never_accepted;
    case Skip::blas:
      return c.skipped_blas_walks;
  }
  return 0;
}

std::string traced_bytes(const Scene& scene, const Camera& camera, AccelKind kind, const TracerOptions& options,
                         unsigned threads = 1) {
  const PreparedGaussians gaussians(scene, true);
  const AccelerationStructure accel(gaussians, {kind, 6, false});
  RenderOptions render;
  render.threads = threads;
  const std::string path =
      (std::filesystem::temp_directory_path() / ("skips_test_" + std::to_string(::getpid()) + ".grtx")).string();
  traces::Writer writer(path, trace_header(scene, camera, accel, options, render));
  frontend::render(scene, gaussians, accel, camera, options, render, &writer);
  writer.finish();
  std::string bytes = read_file(path);
  std::filesystem::remove(path);
  return bytes;
}

TEST(Skips, ChangeNoBitOfTheImageAndAreCounted) {
  const Scene scene = scene_with_everything();
  const Camera camera = test::front_camera(28, 28, 6.0);
  for (const AccelKind kind : {AccelKind::tri20, AccelKind::ellipsoid, AccelKind::tlas_tri20, AccelKind::tlas_sphere}) {
    for (const bool checkpoint : {false, true}) {
      for (const SortKey key : {SortKey::entry, SortKey::peak}) {
        TracerOptions options;
        options.k = 4;
        options.checkpoint = checkpoint;
        options.sort_key = key;
        options.sh_direction = checkpoint ? ShDirection::centre : ShDirection::ray;
        options.skips = {};
        const RenderResult expected = test::trace_scene(scene, camera, kind, options);
        ASSERT_GT(expected.counters.terminated, 20u);
        for (unsigned i = 0; i <= kSkipCount; ++i) {
          const auto skip = static_cast<Skip>(i);
          options.skips = i == kSkipCount ? kAllSkips : Skips{skip};
          SCOPED_TRACE(accel_name(kind) + (i == kSkipCount ? std::string(" all") : " skip " + std::to_string(i)));
          const RenderResult got = test::trace_scene(scene, camera, kind, options);
          EXPECT_EQ(got.image.pixels, expected.image.pixels);
          EXPECT_EQ(got.sequences, expected.sequences);
          EXPECT_EQ(got.counters.blended, expected.counters.blended);
          if (options.skips.faithful()) {
            EXPECT_EQ(work(got.counters), work(expected.counters));
          }
          if (i == kSkipCount) continue;
          if (skip == Skip::blas) {
            EXPECT_EQ(counted(got.counters, skip) > 0, is_two_level(kind));
            if (is_two_level(kind)) {
              EXPECT_LT(got.counters.visits(), expected.counters.visits());
            }
          } else {
            EXPECT_GT(counted(got.counters, skip), 0u);
          }
        }
      }
    }
  }
}

TEST(Skips, OfTheFaithfulKindChangeNoByteOfTheTrace) {
  const Scene scene = scene_with_everything();
  const Camera camera = test::front_camera(16, 16, 6.0);
  for (const AccelKind kind : {AccelKind::tri20, AccelKind::tlas_tri20}) {
    for (const bool checkpoint : {false, true}) {
      TracerOptions options;
      options.k = 4;
      options.checkpoint = checkpoint;
      options.skips = {};
      const std::string expected = traced_bytes(scene, camera, kind, options);
      options.skips = kFaithfulSkips;
      EXPECT_TRUE(traced_bytes(scene, camera, kind, options) == expected) << accel_name(kind);
    }
  }
}

TEST(Skips, ThatAreNotFaithfulAreRefusedForTraces) {
  TracerOptions options;
  options.skips = kAllSkips;
  EXPECT_THROW(traced_bytes(test::random_scene(1, {20}), test::front_camera(8, 8), AccelKind::tri20, options),
               std::logic_error);
}

TEST(Threads, ChangeNoByteOfImageOrTrace) {
  const Scene scene = scene_with_everything();
  const Camera camera = test::front_camera(40, 24, 3.0);
  for (const AccelKind kind : {AccelKind::tri20, AccelKind::tlas_tri20}) {
    TracerOptions options;
    options.checkpoint = kind == AccelKind::tlas_tri20;
    const PreparedGaussians gaussians(scene, true);
    const AccelerationStructure accel(gaussians, {kind, 6, false});
    RenderOptions render;
    render.threads = 1;
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
