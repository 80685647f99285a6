// SPDX-License-Identifier: Apache-2.0
// How far leaves of 32 B move an image: beside the fp64 brute-force reference of the Gaussians as they were.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "frontend/tracer/render_helpers.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/reference/reference.h"
#include "grtx/frontend/scene/scene_io.h"
#include "grtx/frontend/synth/synth.h"
#include "grtx/frontend/tracer/view_tracer.h"

namespace grtx::frontend {
namespace {

class QuantisedImage : public ::testing::TestWithParam<std::pair<const char*, double>> {};

TEST_P(QuantisedImage, IsNearTheReference) {
  const auto& [preset, least_psnr] = GetParam();
  const std::string path =
      (std::filesystem::temp_directory_path() / ("grtx_quantised_" + std::to_string(::getpid()) + ".ply")).string();
  synthesise({preset, 4000, 29, 1}, path);
  const std::string cameras = std::filesystem::path(path).replace_extension(".cameras.json").string();
  const Scene scene = load_scene(path);
  const Camera camera = load_cameras(cameras)[0].resized(40, 30);
  std::filesystem::remove(path);
  std::filesystem::remove(cameras);

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

INSTANTIATE_TEST_SUITE_P(Presets, QuantisedImage,
                         ::testing::Values(std::pair{"room", 55.0}, std::pair{"object", 55.0},
                                           std::pair{"stress-needles", 40.0}),
                         [](const auto& test) {
                           std::string name = test.param.first;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace grtx::frontend
