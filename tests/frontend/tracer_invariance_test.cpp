// The first invariant: with the exact resume rule no setting of the traversal changes a bit of the image, nor which
// Gaussians a ray blends, in which order.
#include <gtest/gtest.h>

#include "frontend/image.h"
#include "random_scene.h"
#include "render_helpers.h"

namespace grtx::frontend {
namespace {

struct Scenario {
  const char* name;
  test::RandomSceneOptions scene;
  double distance;
};

std::ostream& operator<<(std::ostream& out, const Scenario& s) { return out << s.name; }

void expect_same(const RenderResult& expected, const RenderResult& actual, const std::string& what) {
  EXPECT_EQ(compare(expected.image, actual.image).different_pixels, 0u) << what;
  EXPECT_TRUE(expected.sequences == actual.sequences) << what;
}

class TracerInvarianceScenes : public testing::TestWithParam<Scenario> {};

TEST_P(TracerInvarianceScenes, EverySettingGivesTheSameImage) {
  const Scene scene = test::random_scene(11, GetParam().scene);
  const Camera camera = test::front_camera(12, 8, GetParam().distance);
  const PreparedGaussians gaussians(scene, true);
  for (const auto& [monolithic, two_level] :
       {std::pair{AccelKind::tri20, AccelKind::tlas_tri20}, std::pair{AccelKind::ellipsoid, AccelKind::tlas_sphere},
        std::pair{AccelKind::tri80, AccelKind::tlas_tri80}}) {
    const bool brief = monolithic == AccelKind::tri80;  // same code as tri20 but for the number of faces
    const AccelerationStructure first(gaussians, {monolithic, 6, false});
    const AccelerationStructure second(gaussians, {two_level, 6, false});
    TracerOptions options;
    const RenderResult expected = test::trace_scene(scene, camera, first, gaussians, options);
    EXPECT_GT(expected.counters.blended, 200u);
    for (const unsigned k : {1u, 2u, 4u, 8u, 16u, 64u}) {
      if (brief && k != 4) continue;
      options = TracerOptions{};
      options.k = k;
      for (const AccelerationStructure* accel : {&first, &second}) {
        const std::string where = accel_name(accel->options().kind) + " k " + std::to_string(k);
        for (const ChildOrder order : {ChildOrder::near_first, ChildOrder::slot}) {
          for (const TmaxUpdate update : {TmaxUpdate::reported, TmaxUpdate::kth}) {
            options.child_order = order;
            options.tmax_update = update;
            options.checkpoint = false;
            expect_same(expected, test::trace_scene(scene, camera, *accel, gaussians, options), where);
            options.checkpoint = true;
            for (const CheckpointOrder replay :
                 {CheckpointOrder::fifo, CheckpointOrder::lifo, CheckpointOrder::nearest}) {
              for (const ReplayTmax start : {ReplayTmax::infinity, ReplayTmax::kth}) {
                for (const unsigned capacity : {1u, 9u, 1024u}) {
                  options.checkpoint_order = replay;
                  options.replay_tmax = start;
                  options.checkpoint_capacity = capacity;
                  expect_same(expected, test::trace_scene(scene, camera, *accel, gaussians, options),
                              where + " checkpointing, capacity " + std::to_string(capacity));
                }
              }
            }
          }
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, TracerInvarianceScenes,
    testing::Values(Scenario{"mixed", {60, 0.8, -1.8, 1.0, 0.02, 0.95, 2}, 4.0},
                    Scenario{"needles", {70, 0.8, -2.6, 2.2, 0.1, 0.9, 1}, 4.0},
                    Scenario{"opaque", {60, 0.8, -1.8, 0.5, 0.9, 1.0, 0}, 3.0},
                    Scenario{"surrounded", {60, 0.8, -1.2, 0.8, 0.05, 0.5, 1}, 0.2}),
    [](const testing::TestParamInfo<Scenario>& param) { return std::string(param.param.name); });

TEST(TracerInvariance, OverflowHappensAndIsCounted) {
  const Scene scene = test::random_scene(3);
  TracerOptions options;
  options.k = 2;
  options.checkpoint = true;
  options.checkpoint_capacity = 4;
  const RenderResult result = test::trace_scene(scene, test::front_camera(16, 16), AccelKind::tri20, options);
  EXPECT_GT(result.counters.checkpoint_overflows, 0u);
  EXPECT_LE(result.counters.checkpoints_max_per_ray, 4u);
}

TEST(TracerInvariance, WidthAndBoundsDoNotMatter) {
  const Scene scene = test::random_scene(5);
  const Camera camera = test::front_camera(24, 24);
  const RenderResult expected = test::trace_scene(scene, camera, AccelKind::tri20, {});
  for (unsigned width = 2; width <= 8; ++width) {
    expect_same(expected, test::trace_scene(scene, camera, AccelKind::tri20, {}, width), "tri20 width " + std::to_string(width));
    for (const bool corners : {false, true}) {
      expect_same(expected, test::trace_scene(scene, camera, AccelKind::tlas_tri20, {}, width, corners),
                  "tlas-tri20 width " + std::to_string(width));
    }
  }
}

TEST(TracerInvariance, PeakKeysMakeAllStructuresAgree) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const Scene scene = test::random_scene(seed);
    const Camera camera = test::front_camera(32, 32);
    TracerOptions options;
    options.sort_key = SortKey::peak;
    const RenderResult expected = test::trace_scene(scene, camera, AccelKind::tri20, options);
    for (const AccelKind kind : {AccelKind::tri80, AccelKind::ellipsoid, AccelKind::tlas_tri20, AccelKind::tlas_tri80,
                                 AccelKind::tlas_sphere}) {
      for (const bool checkpoint : {false, true}) {
        options.checkpoint = checkpoint;
        expect_same(expected, test::trace_scene(scene, camera, kind, options), accel_name(kind));
      }
    }
  }
}

}  // namespace
}  // namespace grtx::frontend
