// SPDX-License-Identifier: Apache-2.0
// How far leaves of 32 B move an image: beside the fp64 brute-force reference of the Gaussians as they were.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <vector>

#include "frontend/tracer/render_helpers.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/gaussian/prepared_gaussians.h"
#include "grtx/frontend/reference/reference.h"
#include "grtx/frontend/scene/scene_io.h"
#include "grtx/frontend/synth/synth.h"
#include "grtx/frontend/tracer/view_tracer.h"

namespace grtx::frontend {
namespace {

struct SynthScene {
  Scene scene;
  Camera camera;
};

SynthScene synth(const char* preset, std::uint32_t count) {
  const std::string path =
      (std::filesystem::temp_directory_path() / ("grtx_quantised_" + std::to_string(::getpid()) + ".ply")).string();
  synthesise({preset, count, 29, 1}, path);
  const std::string cameras = std::filesystem::path(path).replace_extension(".cameras.json").string();
  SynthScene made{load_scene(path), load_cameras(cameras)[0].resized(40, 30)};
  std::filesystem::remove(path);
  std::filesystem::remove(cameras);
  return made;
}

/// One more Gaussian, a copy of the first, elsewhere and larger.
void add_gaussian(Scene& scene, const glm::vec3& mean, const glm::vec3& scale) {
  const auto coefficients = static_cast<std::ptrdiff_t>(scene.sh.size() / scene.size());
  const std::vector<float> sh(scene.sh.begin(), scene.sh.begin() + coefficients);
  scene.sh.insert(scene.sh.end(), sh.begin(), sh.end());
  scene.opacity.push_back(scene.opacity[0]);
  scene.rotation.push_back(scene.rotation[0]);
  scene.mean.push_back(mean);
  scene.scale.push_back(scale);
}

struct Drawn {
  Image quantised, whole;
  std::uint64_t wide = 0, bytes = 0;
};

Drawn draw(const Scene& scene, const Camera& camera, AccelKind kind = AccelKind::ellipsoid) {
  ViewTracer view(scene, camera);
  Drawn drawn;
  view.build({kind, 6, false, 8, NodeLayout::vulkan_sim});
  drawn.whole = view.trace({}, {.threads = 1}).result.image;
  view.build({kind, 6, false, 8, NodeLayout::quantised});
  drawn.quantised = view.trace({}, {.threads = 1}).result.image;
  drawn.wide = view.accel().counts().wide;
  drawn.bytes = view.accel().image().size();
  EXPECT_EQ(drawn.wide, view.gaussians().wide_count());
  return drawn;
}

class OutlierImage : public ::testing::TestWithParam<const char*> {};

// One Gaussian at 1e6 left 15 to 41 dB of the others, whose grid it stretched.
TEST_P(OutlierImage, OneFarGaussianTakesNothingFromTheOthers) {
  const SynthScene made = synth(GetParam(), 4000);
  const Drawn before = draw(made.scene, made.camera);
  for (const float distance : {1e4f, 1e5f, 1e6f}) {
    SCOPED_TRACE(distance);
    Scene scene = made.scene;
    add_gaussian(scene, {distance, 0.0f, 0.0f}, scene.scale[0]);
    const Drawn drawn = draw(scene, made.camera);
    EXPECT_GE(compare(drawn.whole, drawn.quantised).psnr, 60.0);
    EXPECT_LE(drawn.wide, scene.size() / 8);
    EXPECT_LE(drawn.wide, before.wide + 1 + scene.size() / 100);
    EXPECT_TRUE(compare(drawn.quantised, draw(scene, made.camera, AccelKind::tlas_sphere).quantised).identical());
  }
}

// Skies of trained scenes: one in a hundred far away, on all sides.
TEST_P(OutlierImage, ASkyOfFarGaussiansTakesNothingFromTheOthers) {
  SynthScene made = synth(GetParam(), 4000);
  for (unsigned i = 0; i < 40; ++i) {
    const float angle = 0.157f * static_cast<float>(i);
    add_gaussian(made.scene, {2e5f * std::cos(angle), -1e5f, 2e5f * std::sin(angle)}, glm::vec3(3e3f));
  }
  const Drawn drawn = draw(made.scene, made.camera);
  EXPECT_GE(compare(drawn.whole, drawn.quantised).psnr, 60.0);
  EXPECT_GE(drawn.wide, 40u);
  EXPECT_LE(drawn.wide, made.scene.size() / 16);
}

// Of two equal clusters the grid has one.
TEST_P(OutlierImage, ClustersThatNoGridServesTogether) {
  SynthScene made = synth(GetParam(), 2000);
  const std::size_t count = made.scene.size();
  for (std::size_t g = 0; g < count; ++g) {
    add_gaussian(made.scene, made.scene.mean[g] + glm::vec3(0.0f, 0.0f, 1e6f), made.scene.scale[g]);
  }
  const Drawn drawn = draw(made.scene, made.camera);
  EXPECT_GE(compare(drawn.whole, drawn.quantised).psnr, 60.0);
  EXPECT_LE(drawn.wide, made.scene.size() * 9 / 16);
}

// A wide leaf holds the whole Gaussian, so what is drawn of it is what other layouts draw: by the fp64 reference.
TEST_P(OutlierImage, WideLeavesAreNearTheReference) {
  SynthScene made = synth(GetParam(), 2000);
  add_gaussian(made.scene, {1e6f, 0.0f, 0.0f}, made.scene.scale[0]);
  add_gaussian(made.scene, made.scene.mean[1], glm::vec3(1e25f));  // beyond the exponents of a row
  ReferenceOptions reference;
  reference.proxy = ReferenceProxy::sphere;
  const Image expected = render_reference(made.scene, made.camera, reference).image;
  const Drawn drawn = draw(made.scene, made.camera);
  EXPECT_GE(drawn.wide, 2u);
  EXPECT_GT(compare(expected, drawn.quantised).psnr, 55.0);
}
INSTANTIATE_TEST_SUITE_P(Presets, OutlierImage, ::testing::Values("building", "hall", "room", "garden", "object"));

// A picture of NaN.
TEST(QuantisedImage, HarmonicsBeyondFp16AreClampedAndCounted) {
  SynthScene made = synth("object", 1000);
  for (std::size_t i = 0; i < 300; ++i) made.scene.sh[i] = i % 2 == 0 ? 1e5f : -7e4f;
  ViewTracer view(made.scene, made.camera);
  view.build({AccelKind::ellipsoid, 6, false, 8, NodeLayout::quantised});
  EXPECT_EQ(view.clamped_sh(), 300u);
  const TracedView traced = view.trace({}, {.threads = 1});
  EXPECT_EQ(traced.inputs.at("clamped_sh"), "300 of " + std::to_string(made.scene.sh.size()));
  for (const glm::vec3& p : traced.result.image.pixels) EXPECT_TRUE(std::isfinite(p.x + p.y + p.z));
  view.build({AccelKind::ellipsoid, 6, false, 8, NodeLayout::vulkan_sim});
  EXPECT_EQ(view.clamped_sh(), 0u);
  EXPECT_FALSE(view.trace({}, {.threads = 1}).inputs.contains("clamped_sh"));
}

class QuantisedScene : public ::testing::TestWithParam<std::pair<const char*, double>> {};

TEST_P(QuantisedScene, IsNearTheReference) {
  const auto& [preset, least_psnr] = GetParam();
  const auto [scene, camera] = synth(preset, 4000);
  ReferenceOptions reference;
  reference.proxy = ReferenceProxy::sphere;
  const Image expected = render_reference(scene, camera, reference).image;
  ViewTracer view(scene, camera);
  const auto drawn = [&](AccelKind kind, NodeLayout layout) {
    view.build({kind, 6, false, 8, layout});
    return view.trace({}, {.threads = 1}).result.image;
  };
  const Image quantised = drawn(AccelKind::ellipsoid, NodeLayout::quantised);
  EXPECT_GT(compare(expected, quantised).psnr, least_psnr);
  EXPECT_FALSE(compare(expected, quantised).identical());
  // The order of layouts does not matter: the Gaussians are prepared anew.
  const Image plain = drawn(AccelKind::ellipsoid, NodeLayout::vulkan_sim);
  EXPECT_GT(compare(expected, plain).psnr, compare(expected, quantised).psnr);
  EXPECT_TRUE(compare(quantised, drawn(AccelKind::tlas_sphere, NodeLayout::quantised)).identical());
}

INSTANTIATE_TEST_SUITE_P(Presets, QuantisedScene,
                         ::testing::Values(std::pair{"room", 55.0}, std::pair{"object", 55.0},
                                           std::pair{"stress-needles", 40.0}),
                         [](const auto& test) {
                           std::string name = test.param.first;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace grtx::frontend
