// SPDX-License-Identifier: Apache-2.0
// The fp32 tracer against the fp64 brute force on every generated, stress and trained scene: picture, and which
// Gaussians a ray blends in which order. Every ray that differs must be explained by gaps below the bounds of
// docs/model/numerics.md.
#include <gtest/gtest.h>

#include <cstdio>

#include "frontend/synth/stress_scenes.h"
#include "frontend/tracer/parity.h"
#include "frontend/tracer/render_helpers.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/reference/reference.h"
#include "parameter_names.h"
#include "real_scene_files.h"

namespace grtx::frontend {
namespace {

// docs/model/numerics.md, "Parity with the reference".
constexpr test::Explanation kBounds{1e-6, 2e-3, 2e-3, 2e-3};
constexpr double kMaxDifferentShare = 1e-3;

struct Structure {
  AccelKind accel;
  ReferenceProxy proxy;
  bool peak;
};
constexpr Structure kStructures[] = {{AccelKind::tlas_tri20, ReferenceProxy::icosahedron20, false},
                                     {AccelKind::tlas_tri80, ReferenceProxy::icosphere80, false},
                                     {AccelKind::tlas_sphere, ReferenceProxy::sphere, false},
                                     {AccelKind::tlas_tri20, ReferenceProxy::icosahedron20, true}};

void expect_parity(const std::string& name, const Scene& scene, const std::vector<Camera>& cameras, double least_psnr) {
  const PreparedGaussians gaussians(scene, true);
  test::Parity all;
  double worst_psnr = std::numeric_limits<double>::infinity();
  for (const Structure& s : kStructures) {
    const AccelerationStructure accel(gaussians, {s.accel, 6, false});
    for (const Camera& camera : cameras) {
      TracerOptions options;
      options.sort_key = s.peak ? SortKey::peak : SortKey::entry;
      const RenderResult traced = test::trace_scene(scene, camera, accel, gaussians, options);
      ReferenceOptions reference;
      reference.proxy = s.proxy;
      reference.sort_by_peak = s.peak;
      reference.keep_sequences = reference.keep_candidates = true;
      const ReferenceResult exact = render_reference(scene, camera, reference);
      const double psnr = compare(traced.image, exact.image).psnr;
      const test::Parity parity = test::compare_sequences(traced.sequences, exact, static_cast<double>(options.ert));
      const std::string where = accel_name(s.accel) + (s.peak ? " peak " : " entry ") + camera.name;
      EXPECT_GE(psnr, least_psnr) << where;
      EXPECT_LE(parity.needed.t, kBounds.t) << where;
      EXPECT_LE(parity.needed.radius, kBounds.radius) << where;
      EXPECT_LE(parity.needed.alpha, kBounds.alpha) << where;
      EXPECT_LE(parity.needed.transmittance, kBounds.transmittance) << where;
      for (const glm::vec3& pixel : traced.image.pixels) {
        ASSERT_TRUE(std::isfinite(pixel.x) && std::isfinite(pixel.y) && std::isfinite(pixel.z)) << where;
      }
      worst_psnr = std::min(worst_psnr, psnr);
      all.rays += parity.rays;
      all.different += parity.different;
      all.needed.take(parity.needed);
    }
  }
  EXPECT_LE(static_cast<double>(all.different), kMaxDifferentShare * static_cast<double>(all.rays));
  std::printf("| %s | %.1f | %zu of %zu | %.1e | %.1e | %.1e | %.1e |\n", name.c_str(), worst_psnr, all.different,
              all.rays, all.needed.t, all.needed.radius, all.needed.alpha, all.needed.transmittance);
}

class TracerParityGenerated : public testing::TestWithParam<std::string> {};

TEST_P(TracerParityGenerated, PictureAndSequences) {
  const bool stress = GetParam().rfind("stress-", 0) == 0;
  const test::GeneratedScene generated = test::generated_scene(GetParam(), stress ? 700 : 1500);
  std::vector<Camera> cameras;
  for (std::size_t view = 0; view < generated.cameras.size(); ++view) {
    cameras.push_back(test::small_view(generated, view, 24));
  }
  expect_parity(GetParam(), generated.scene, cameras, stress ? 50.0 : 60.0);
}

INSTANTIATE_TEST_SUITE_P(Presets, TracerParityGenerated, testing::ValuesIn(synth_presets()), test::preset_test_name);

struct RealScene {
  const char* file;
  const char* cameras;
};
std::ostream& operator<<(std::ostream& out, const RealScene& s) { return out << s.file; }

class TracerParityReal : public testing::TestWithParam<RealScene> {};

TEST_P(TracerParityReal, PictureAndSequences) {
  const std::string path = test::real_scene_path(GetParam().file);
  const std::string cameras_path = test::real_cameras_path(GetParam().cameras);
  if (path.empty() || cameras_path.empty()) {
    GTEST_SKIP() << "no real scenes: put them into ../shared/scenes or name the folder in GRTX_SCENES";
  }
  std::vector<Camera> cameras;
  for (const Camera& camera : load_cameras(cameras_path)) cameras.push_back(camera.resized(32, 32));
  expect_parity(GetParam().file, load_scene(path), cameras, 60.0);
}

// The largest scene has two smaller levels of detail of itself here.
INSTANTIATE_TEST_SUITE_P(Scenes, TracerParityReal,
                         testing::Values(RealScene{"statue_st-peter_sh0", "st-peter"},
                                         RealScene{"pizza_161k_sh3", "pizza"}, RealScene{"logo_307k_sh0", "logo"},
                                         RealScene{"playbot_L2", "playbot"}, RealScene{"playbot_L6", "playbot"}),
                         test::PrintedName{});

}  // namespace
}  // namespace grtx::frontend
