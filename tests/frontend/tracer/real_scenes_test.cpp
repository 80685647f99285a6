// SPDX-License-Identifier: Apache-2.0
// Trained scenes of several programs load with the counts that their files announce. Skipped where they are missing:
// GRTX_SCENES (a folder of .ply or .ply.xz files) or ../shared/scenes beside the project.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "frontend/scene/scene_bytes.h"
#include "parameter_names.h"
#include "real_scene_files.h"

namespace grtx::frontend::test {
namespace {

using grtx::test::real_cameras_path;
using grtx::test::real_scene_path;

struct SceneCase {
  const char* name;
  std::size_t gaussians;
  unsigned sh_degree;
  friend void PrintTo(const SceneCase& c, std::ostream* out) { *out << c.name; }
};
class RealScenes : public testing::TestWithParam<SceneCase> {};

TEST_P(RealScenes, LoadWithoutLoss) {
  const auto& [name, gaussians, sh_degree] = GetParam();
  const std::string path = real_scene_path(name);
  if (path.empty()) GTEST_SKIP() << name << " is missing";
  const Scene scene = load_scene(path);
  EXPECT_EQ(scene.report.rows, gaussians);
  EXPECT_EQ(scene.size(), gaussians);
  EXPECT_EQ(scene.sh_degree, sh_degree);
  EXPECT_TRUE(scene.report.dropped.empty());
  EXPECT_EQ(scene.sh.size(), gaussians * scene.sh_coefficients() * 3);
  for (std::size_t i = 0; i < scene.size(); ++i) {
    ASSERT_GE(std::min({scene.scale[i].x, scene.scale[i].y, scene.scale[i].z}), 1e-6f) << i;
    ASSERT_NEAR(glm::dot(scene.rotation[i], scene.rotation[i]), 1.0f, 1e-6f) << i;
    ASSERT_TRUE(scene.opacity[i] >= 0.0f && scene.opacity[i] <= 1.0f) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Trained, RealScenes,
                         testing::Values(SceneCase{"playbot_500k_sh2", 500000, 2},
                                         SceneCase{"pizza_161k_sh3", 160554, 3}, SceneCase{"logo_307k_sh0", 307128, 0},
                                         SceneCase{"statue_st-peter_sh0", 133618, 0}),
                         grtx::test::PrintedName{});

TEST(RealCameras, LoadFromTheSharedFolder) {
  for (const char* name : {"playbot", "pizza", "logo", "st-peter"}) {
    const std::string path = real_cameras_path(name);
    if (path.empty()) GTEST_SKIP() << name << " is missing";
    const std::vector<Camera> cameras = load_cameras(path);
    ASSERT_EQ(cameras.size(), 2u);
    for (const Camera& camera : cameras) {
      EXPECT_EQ(camera.width, 128u);
      EXPECT_EQ(camera.cx, 64.0);
    }
  }
}

}  // namespace
}  // namespace grtx::frontend::test
