// The dense_indoor preset is of the paper's kind: behind the hit that ends a ray lie many more, and nearly every ray
// ends by early ray termination (docs/model/synthetic-scenes.md).
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "frontend/tracer/render_helpers.h"
#include "grtx/frontend/scene/scene_io.h"
#include "grtx/frontend/synth/synth.h"

namespace grtx::frontend {
namespace {

struct Request {
  std::uint64_t count, seed;
};

class DenseIndoor : public ::testing::TestWithParam<Request> {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("grtx_dense_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    const std::string file = (folder_ / "scene.ply").string();
    synthesise({"dense_indoor", GetParam().count, GetParam().seed, 0}, file);
    scene_ = load_scene(file);
    views_ = load_cameras((folder_ / "scene.cameras.json").string());
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
  Scene scene_;
  std::vector<Camera> views_;
};

TEST_P(DenseIndoor, RaysMeetEightTimesAsManyHitsAsTheyProcessAndEndEarly) {
  const PreparedGaussians gaussians(scene_, true);
  const AccelerationStructure accel(gaussians, {AccelKind::tlas_tri20, 6, false});
  ASSERT_EQ(views_.size(), 4u);
  std::uint64_t hits = 0, processed = 0;
  for (const Camera& view : views_) {
    TracerOptions options;
    options.k = 64;
    const TracerCounters ended = test::trace_scene(scene_, view.resized(12, 12), accel, gaussians, options).counters;
    options.ert = 0.0f;  // no transmittance is below it: every hit of the ray is processed
    options.tracing = Tracing::single;
    options.k = kMaxK;
    const TracerCounters whole = test::trace_scene(scene_, view.resized(12, 12), accel, gaussians, options).counters;
    ASSERT_EQ(whole.terminated, 0u);
    EXPECT_GT(10 * ended.terminated, 9 * ended.rays) << view.name;
    // Hits that a ray looks at before it ends: as in trained scenes, where 30 to 70 are blended.
    EXPECT_GE(ended.processed, 30 * ended.rays) << view.name;
    EXPECT_LE(ended.processed, 75 * ended.rays) << view.name;
    hits += whole.processed;
    processed += ended.processed;
  }
  EXPECT_GE(hits, 8 * processed) << hits << " hits, " << processed << " processed";
}

INSTANTIATE_TEST_SUITE_P(Instances, DenseIndoor, ::testing::Values(Request{40000, 1}, Request{40000, 2}),
                         [](const auto& request) {
                           return std::to_string(request.param.count) + "_seed_" + std::to_string(request.param.seed);
                         });

}  // namespace
}  // namespace grtx::frontend
