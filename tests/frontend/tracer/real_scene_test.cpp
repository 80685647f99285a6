// SPDX-License-Identifier: Apache-2.0
// Anchors on real trained scenes: bytes a Gaussian of both structures, image identity. Skipped where the scenes lack.
#include <gtest/gtest.h>

#include "frontend/tracer/render_helpers.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/scene/scene_io.h"
#include "parameter_names.h"
#include "real_scene_files.h"

namespace grtx::frontend {
namespace {

struct RealScene {
  const char* file;
  const char* cameras;
};
std::ostream& operator<<(std::ostream& out, const RealScene& s) { return out << s.file; }

class RealSceneTest : public testing::TestWithParam<RealScene> {};

TEST_P(RealSceneTest, StructureSizesAndImageIdentity) {
  const std::string path = test::real_scene_path(GetParam().file);
  const std::string cameras = test::real_cameras_path(GetParam().cameras);
  if (path.empty() || cameras.empty()) {
    GTEST_SKIP() << "no real scenes: put them into ../shared/scenes or name the folder in GRTX_SCENES";
  }
  const Scene scene = load_scene(path);
  const Camera camera = load_cameras(cameras)[0].resized(48, 48);
  const PreparedGaussians gaussians(scene, true);
  const double count = static_cast<double>(scene.size());
  const AccelerationStructure monolithic(gaussians, {AccelKind::tri20, 6, false});
  const AccelerationStructure two_level(gaussians, {AccelKind::tlas_tri20, 6, false});
  // The paper's table in binary units, +-1.5 %.
  EXPECT_GE(static_cast<double>(monolithic.image().size()) / count, 1705.0 * 0.985);
  EXPECT_LE(static_cast<double>(monolithic.image().size()) / count, 1721.0 * 1.015);
  EXPECT_GE(static_cast<double>(two_level.image().size()) / count, 147.6 * 0.985);
  EXPECT_LE(static_cast<double>(two_level.image().size()) / count, 149.4 * 1.015 + 2048.0 / count);
  TracerOptions options;
  const RenderResult expected = test::trace_scene(scene, camera, monolithic, gaussians, options);
  EXPECT_GT(expected.counters.blended, 1000u);
  for (const AccelerationStructure* accel : {&monolithic, &two_level}) {
    for (const bool checkpoint : {false, true}) {
      options.checkpoint = checkpoint;
      const RenderResult actual = test::trace_scene(scene, camera, *accel, gaussians, options);
      EXPECT_EQ(compare(expected.image, actual.image).different_pixels, 0u);
      EXPECT_TRUE(expected.sequences == actual.sequences);
    }
  }
}

// The two largest scenes are left to bench/: their monolithic builds take a minute on two cores.
INSTANTIATE_TEST_SUITE_P(Scenes, RealSceneTest,
                         testing::Values(RealScene{"statue_st-peter_sh0", "st-peter"},
                                         RealScene{"pizza_161k_sh3", "pizza"}, RealScene{"playbot_L2", "playbot"}),
                         test::PrintedName{});

}  // namespace
}  // namespace grtx::frontend
