// SPDX-License-Identifier: Apache-2.0
// The fp32 tracer against the fp64 brute force of the same proxy and sort key: it shares no code with the tracer.
#include <gtest/gtest.h>

#include "frontend/tracer/random_scene.h"
#include "frontend/tracer/render_helpers.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/reference/reference.h"
#include "parameter_names.h"

namespace grtx::frontend {
namespace {

struct Case {
  AccelKind accel;
  ReferenceProxy proxy;
  bool peak;
  unsigned degree = 2;  ///< of the kernel
  friend void PrintTo(const Case& c, std::ostream* out) {
    *out << accel_name(c.accel) << (c.peak ? " by peak" : " by entry");
    if (c.degree != 2) *out << " degree " << c.degree;
  }
};

class TracerReference : public testing::TestWithParam<Case> {};

TEST_P(TracerReference, PsnrAndSequences) {
  const Case c = GetParam();
  const Scene scene = test::random_scene(21);
  const Camera camera = test::front_camera(48, 48);
  TracerOptions options{.sort_key = c.peak ? SortKey::peak : SortKey::entry, .kernel = {true, c.degree}};
  const RenderResult traced = test::trace_scene(scene, camera, c.accel, options);
  ReferenceOptions reference;
  reference.proxy = c.proxy;
  reference.sort_by_peak = c.peak;
  reference.kernel_degree = c.degree;
  reference.keep_sequences = true;
  const ReferenceResult exact = render_reference(scene, camera, reference);
  EXPECT_GE(compare(traced.image, exact.image).psnr, 90.0);
  std::size_t different = 0;
  for (std::size_t p = 0; p < exact.sequences.size(); ++p) {
    std::vector<std::uint32_t> ids;
    for (const ReferenceHit& hit : exact.sequences[p]) ids.push_back(hit.gaussian);
    if (ids != traced.sequences[p]) ++different;
  }
  EXPECT_LE(different, exact.sequences.size() / 1000);
}

INSTANTIATE_TEST_SUITE_P(Proxies, TracerReference,
                         testing::Values(Case{AccelKind::tri20, ReferenceProxy::icosahedron20, false},
                                         Case{AccelKind::tri80, ReferenceProxy::icosphere80, false},
                                         Case{AccelKind::tlas_sphere, ReferenceProxy::sphere, false},
                                         Case{AccelKind::tlas_sphere, ReferenceProxy::sphere, false, 4},
                                         Case{AccelKind::tri20, ReferenceProxy::icosahedron20, true, 4},
                                         Case{AccelKind::tlas_tri20, ReferenceProxy::icosahedron20, true},
                                         Case{AccelKind::ellipsoid, ReferenceProxy::sphere, true}),
                         test::PrintedName{});

/// Of the picture, in dB, with the proxy's own reference.
double parity(const Scene& scene, const Camera& camera, AccelKind kind, ReferenceProxy proxy,
              ShDirection direction = ShDirection::ray) {
  TracerOptions options;
  options.sh_direction = direction;
  ReferenceOptions reference;
  reference.proxy = proxy;
  reference.sh_from_centre = direction == ShDirection::centre;
  return compare(test::trace_scene(scene, camera, kind, options).image,
                 render_reference(scene, camera, reference).image)
      .psnr;
}

TEST(TracerReferenceFaults, HarmonicsOfDegree4Count) {
  const Scene scene = test::random_scene(45, {200, 1.0, -2.0, 1.0, 0.05, 0.95, 4});
  for (const ShDirection direction : {ShDirection::ray, ShDirection::centre}) {
    EXPECT_GE(parity(scene, test::front_camera(32, 32), AccelKind::tlas_sphere, ReferenceProxy::sphere, direction), 90);
  }
}

// A pixel adds up colours with weights of 1 in all, and each has an error of half a step of fp16 at most.
TEST(ColoursOnceInAFrame, DifferByTheirRoundingAlone) {
  const Scene scene = test::random_scene(46, {.count = 300, .log_scale_mean = -1.5, .sh_degree = 3});
  const Camera camera = test::front_camera(32, 32);
  for (const AccelKind kind : {AccelKind::tri20, AccelKind::tlas_sphere, AccelKind::ellipsoid}) {
    TracerOptions options;
    options.sh_direction = ShDirection::centre;
    const RenderResult hit = test::trace_scene(scene, camera, kind, options);
    options.colour = ColourPer::frame;
    const RenderResult frame = test::trace_scene(scene, camera, kind, options);
    EXPECT_EQ(frame.sequences, hit.sequences);
    std::size_t rounded = 0;
    for (std::size_t i = 0; i < hit.image.pixels.size(); ++i) {
      for (int c = 0; c < 3; ++c) {
        const float exact = hit.image.pixels[i][c], got = frame.image.pixels[i][c];
        EXPECT_NEAR(got, exact, exact * 0x1p-10f + 0x1p-24f);
        rounded += got != exact ? 1 : 0;
      }
    }
    EXPECT_GT(rounded, hit.image.pixels.size() / 2);
  }
}

// |direction|^2 in the unit frame is no float there. Powers of two: the scene is the same but for its size.
TEST(TracerReferenceFaults, SpheresFromScale1e20OnDoNotHoldEveryOrigin) {
  const std::pair<AccelKind, ReferenceProxy> kinds[] = {
      {AccelKind::tlas_sphere, ReferenceProxy::sphere},  {AccelKind::ellipsoid, ReferenceProxy::sphere},
      {AccelKind::box, ReferenceProxy::sphere},          {AccelKind::tlas_box, ReferenceProxy::sphere},
      {AccelKind::tri20, ReferenceProxy::icosahedron20}, {AccelKind::tlas_tri80, ReferenceProxy::icosphere80}};
  for (const int exponent : {0, 60, 66, 73, 90, 110, 120}) {
    Scene scene = test::random_scene(21);
    for (std::size_t g = 0; g < scene.size(); ++g) {
      scene.mean[g] *= std::ldexp(1.0f, exponent);
      scene.scale[g] *= std::ldexp(1.0f, exponent);
    }
    Camera camera = test::front_camera(32, 32);
    camera.position *= std::ldexp(1.0, exponent);
    for (const auto& [kind, proxy] : kinds) {
      for (const ShDirection direction : {ShDirection::ray, ShDirection::centre}) {
        EXPECT_GE(parity(scene, camera, kind, proxy, direction), 80) << exponent << " " << accel_name(kind);
      }
    }
  }
}

}  // namespace
}  // namespace grtx::frontend
