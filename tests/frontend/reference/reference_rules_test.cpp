// SPDX-License-Identifier: Apache-2.0
// The reference follows the rules of blending, acceptance, ordering and rays that start inside, one case each.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <glm/geometric.hpp>

#include "grtx/base/error.h"
#include "grtx/frontend/reference/reference.h"
#include "grtx/frontend/reference/reference_sh.h"
#include "grtx/frontend/reference/reference_solid.h"
#include "limited_memory.h"

namespace grtx::frontend {
namespace {

constexpr float kC0 = 0.28209479177387814f;

/// Isotropic Gaussians on the z axis, grey level c.
void add(Scene& scene, glm::vec3 mean, float scale, float opacity, float grey = 1.0f) {
  scene.mean.push_back(mean);
  scene.scale.emplace_back(scale);
  scene.rotation.emplace_back(1.0f, 0.0f, 0.0f, 0.0f);
  scene.opacity.push_back(opacity);
  for (int c = 0; c < 3; ++c) scene.sh.push_back((grey - 0.5f) / kC0);
}

/// One ray along +z from the origin, exactly.
Camera one_ray() {
  Camera camera;
  camera.width = camera.height = 1;
  camera.fx = camera.fy = 1.0;
  camera.cx = camera.cy = 0.5;
  return camera;
}

ReferenceResult trace(const Scene& scene, ReferenceOptions options = {}) {
  options.keep_sequences = true;
  return render_reference(scene, one_ray(), options);
}

TEST(ReferenceRules, EmptySceneIsBlack) {
  const ReferenceResult result = trace(Scene());
  EXPECT_EQ(result.image.at(0, 0), glm::vec3(0.0f));
  EXPECT_TRUE(result.sequences[0].empty());
}

TEST(ReferenceRules, CentralHitHasAlphaOpacityCappedAt99Percent) {
  for (const float opacity : {0.25f, 0.5f, 0.99f, 1.0f}) {
    Scene scene;
    add(scene, {0, 0, 5}, 0.1f, opacity, 0.75f);
    const ReferenceResult result = trace(scene);
    ASSERT_EQ(result.sequences[0].size(), 1u);
    const double alpha = std::min(0.99, static_cast<double>(opacity));
    EXPECT_DOUBLE_EQ(result.sequences[0][0].alpha, alpha);
    EXPECT_NEAR(result.image.at(0, 0).x, 0.75 * alpha, 1e-6);
  }
}

TEST(ReferenceRules, TilesOfAnImageAreThoseOfTheWholeImage) {
  Scene scene;
  add(scene, {0, 0, 5}, 1.0f, 0.9f, 0.75f);
  add(scene, {1, 1, 4}, 0.5f, 0.5f, 0.25f);
  Camera camera;
  camera.width = 100;
  camera.height = 36;
  camera.fx = camera.fy = 60.0;
  camera.cx = 50.0;
  camera.cy = 18.0;
  ReferenceOptions options;
  const ReferenceResult whole = render_reference(scene, camera, options);
  EXPECT_TRUE(whole.rendered.empty());
  options.tiles_a_side = 3;
  const ReferenceResult tiles = render_reference(scene, camera, options);
  // Of 13 columns the tiles 2, 6, 10; of 5 rows 0, 2, 4, the last of which has four lines.
  ASSERT_EQ(tiles.rendered.size(), 3u * 8 * (8 + 8 + 4));
  EXPECT_EQ(tiles.rendered.front(), 16u);
  EXPECT_EQ(tiles.rendered.back(), 35u * 100 + 87);
  EXPECT_TRUE(std::is_sorted(tiles.rendered.begin(), tiles.rendered.end()));
  for (const std::size_t pixel : tiles.rendered) EXPECT_EQ(tiles.image.pixels[pixel], whole.image.pixels[pixel]);
  EXPECT_EQ(tiles.image.at(0, 0), glm::vec3(0.0f));
  options.tiles_a_side = 100;
  EXPECT_EQ(render_reference(scene, camera, options).rendered.size(), 3600u);
}

TEST(ReferenceRules, TooTransparentIsNeverBlended) {
  struct Case {
    float opacity;
    std::size_t hits;
  };
  for (const Case& c : {Case{0.0f, 0}, Case{0.0039f, 0}, Case{0.00393f, 1}, Case{0.01f, 1}}) {
    Scene scene;
    add(scene, {0, 0, 5}, 0.1f, c.opacity);
    EXPECT_EQ(trace(scene).sequences[0].size(), c.hits) << c.opacity;
  }
}

TEST(ReferenceRules, RadiusIsAdaptiveOrThreeSigma) {
  // kappa(o = 1) = sqrt(-2 ln 0.0113) = 2.99427; kappa(o = 0.1) = 2.08823; the floor gives 0.24682.
  struct Case {
    float opacity, offset;  // offset in sigma
    bool adaptive;
    std::size_t hits;
  };
  for (const Case& c : {Case{1.0f, 2.994f, true, 1}, Case{1.0f, 2.995f, true, 0}, Case{1.0f, 2.999f, false, 1},
                        Case{1.0f, 3.001f, false, 0}, Case{0.1f, 2.088f, true, 1}, Case{0.1f, 2.089f, true, 0},
                        Case{0.1f, 2.089f, false, 1}, Case{0.01f, 0.2467f, true, 1}, Case{0.01f, 0.2469f, true, 0}}) {
    Scene scene;
    add(scene, {c.offset, 0, 500}, 1.0f, c.opacity);
    ReferenceOptions options;
    options.adaptive_radius = c.adaptive;
    for (const ReferenceProxy proxy :
         {ReferenceProxy::icosahedron20, ReferenceProxy::icosphere80, ReferenceProxy::sphere}) {
      options.proxy = proxy;
      EXPECT_EQ(trace(scene, options).sequences[0].size(), c.hits) << c.opacity << ' ' << c.offset;
    }
  }
}

TEST(ReferenceRules, SphereEntryIsTheQuadraticsRoot) {
  Scene scene;
  add(scene, {0.1f, 0, 5}, 0.1f, 1.0f);
  ReferenceOptions options;
  options.proxy = ReferenceProxy::sphere;
  const double kappa = std::sqrt(-2.0 * std::log(0.0113));
  const double x = static_cast<double>(0.1f);
  EXPECT_NEAR(trace(scene, options).sequences[0][0].t, 5.0 - std::sqrt(kappa * kappa * x * x - x * x), 1e-12);
  options.sort_by_peak = true;
  EXPECT_DOUBLE_EQ(trace(scene, options).sequences[0][0].t, 5.0);
}

TEST(ReferenceRules, EqualDistancesAreOrderedById) {
  Scene scene;
  for (int i = 0; i < 40; ++i) add(scene, {0, 0, 5}, 0.1f, 0.05f, static_cast<float>(i) / 40.0f);
  const ReferenceResult result = trace(scene);
  ASSERT_EQ(result.sequences[0].size(), 40u);
  for (std::uint32_t i = 0; i < 40; ++i) EXPECT_EQ(result.sequences[0][i].gaussian, i);
}

TEST(ReferenceRules, StopsRightAfterTheHitThatPassesTheThreshold) {
  Scene scene;
  for (int i = 0; i < 20; ++i) add(scene, {0, 0, 5.0f + static_cast<float>(i)}, 0.1f, 0.5f);
  ReferenceOptions options;
  EXPECT_EQ(trace(scene, options).sequences[0].size(), 10u);  // 0.5^10 = 0.00098 < 0.001
  options.ert = 0.25;
  EXPECT_EQ(trace(scene, options).sequences[0].size(), 3u);  // 0.25 is not below 0.25
  options.ert = 0.0;
  EXPECT_EQ(trace(scene, options).sequences[0].size(), 20u);
}

TEST(ReferenceRules, ProxyAroundTheOriginIsSkippedUnlessCounted) {
  Scene scene;
  add(scene, {0, 0, 0.05f}, 0.1f, 0.5f);   // holds the origin, peak ahead
  add(scene, {0, 0, -0.05f}, 0.1f, 0.5f);  // holds the origin, peak behind
  add(scene, {0, 0, -5.0f}, 0.1f, 0.5f);   // behind
  add(scene, {0, 0, 5.0f}, 0.1f, 0.5f);    // ahead
  for (const ReferenceProxy proxy :
       {ReferenceProxy::icosahedron20, ReferenceProxy::icosphere80, ReferenceProxy::sphere}) {
    for (const bool peak : {false, true}) {
      ReferenceOptions options;
      options.proxy = proxy;
      options.sort_by_peak = peak;
      const ReferenceResult result = trace(scene, options);
      ASSERT_EQ(result.sequences[0].size(), 1u);
      EXPECT_EQ(result.sequences[0][0].gaussian, 3u);
    }
  }
  ReferenceOptions options;
  options.proxy = ReferenceProxy::sphere;
  options.count_inside = true;
  const ReferenceResult counted = trace(scene, options);
  ASSERT_EQ(counted.sequences[0].size(), 2u);
  EXPECT_EQ(counted.sequences[0][0].gaussian, 0u);
  EXPECT_EQ(counted.sequences[0][0].t, 0.0);
  options.sort_by_peak = true;
  EXPECT_NEAR(trace(scene, options).sequences[0][0].t, 0.05, 1e-8);
  options.proxy = ReferenceProxy::icosahedron20;
  EXPECT_THROW(trace(scene, options), Error);
}

TEST(ReferenceRules, PeakSortMakesTheImageIndependentOfTheProxy) {
  Scene scene;
  for (int i = 0; i < 300; ++i) {
    const float a = static_cast<float>(i);
    add(scene, {std::sin(a * 1.3f), std::cos(a * 2.1f), 5.0f + std::sin(a * 0.7f)}, 0.05f + 0.001f * a, 0.3f,
        0.003f * a);
  }
  Camera camera = one_ray();
  camera.width = camera.height = 24;
  camera.fx = camera.fy = 30.0;
  camera.cx = camera.cy = 12.0;
  ReferenceOptions options;
  options.sort_by_peak = true;
  const Image first = render_reference(scene, camera, options).image;
  for (const ReferenceProxy proxy : {ReferenceProxy::icosphere80, ReferenceProxy::sphere}) {
    options.proxy = proxy;
    EXPECT_TRUE(compare(first, render_reference(scene, camera, options).image).identical());
  }
}

TEST(ReferenceRules, ThreadsDoNotChangeAnyBit) {
  Scene scene;
  for (int i = 0; i < 200; ++i) {
    add(scene, {std::sin(static_cast<float>(i)), std::cos(static_cast<float>(i)), 4.0f}, 0.1f, 0.4f,
        0.004f * static_cast<float>(i));
  }
  Camera camera = one_ray();
  camera.width = 33;
  camera.height = 19;
  camera.fx = camera.fy = 20.0;
  camera.cx = 16.5;
  camera.cy = 9.5;
  ReferenceOptions options;
  options.threads = 1;
  const Image one = render_reference(scene, camera, options).image;
  options.threads = 7;
  EXPECT_TRUE(compare(one, render_reference(scene, camera, options).image).identical());
}

TEST(ReferenceRules, AsksForNoMoreThreadsThanAreGiven) {
  Camera camera = one_ray();
  camera.width = camera.height = 64 * kReferenceTile;
  ReferenceOptions options;
  options.threads = 4096;  // as many as tiles; their stacks alone are more than is left
  const test::LimitedMemory limited(std::uint64_t{1} << 30);
  EXPECT_EQ(render_reference(Scene(), camera, options).image.at(7, 5), glm::vec3(0.0f));
}

TEST(ReferenceRules, PixelsWithoutARayAreBlack) {
  Scene scene;
  add(scene, {0, 0, 5}, 1.3f, 1.0f);
  Camera camera = one_ray();
  camera.width = camera.height = 17;
  camera.cx = camera.cy = 8.5;
  camera.projection = Projection::fisheye;
  camera.fisheye_fov = 3.0;
  const ReferenceResult result = render_reference(scene, camera, {});
  EXPECT_EQ(result.image.at(0, 0), glm::vec3(0.0f));
  EXPECT_NEAR(result.image.at(8, 8).x, 0.99f, 1e-6f);
}

TEST(ReferenceSolid, SlabsAndRadiiMatchThePublishedConstants) {
  const std::vector<ReferenceSlab> ten = reference_slabs(ReferenceProxy::icosahedron20);
  ASSERT_EQ(ten.size(), 10u);
  for (const ReferenceSlab& slab : ten) EXPECT_NEAR(slab.distance, 1.0, 1e-12);
  EXPECT_NEAR(reference_circumradius(ReferenceProxy::icosahedron20), 1.2584085724, 1e-10);
  const std::vector<ReferenceSlab> forty = reference_slabs(ReferenceProxy::icosphere80);
  ASSERT_EQ(forty.size(), 40u);
  int farther = 0;
  for (const ReferenceSlab& slab : forty) {
    const bool far = slab.distance > 1.005;
    EXPECT_NEAR(slab.distance, far ? 0.943522191 / 0.934172359 : 1.0, 2e-9);
    farther += far ? 1 : 0;
  }
  EXPECT_THAT(farther, ::testing::AnyOf(10, 30));  // the middle triangles form one class, the corner ones the other
  EXPECT_NEAR(reference_circumradius(ReferenceProxy::icosphere80), 1.0704662693, 1e-10);
  EXPECT_TRUE(reference_slabs(ReferenceProxy::sphere).empty());
}

TEST(ReferenceColour, BasisEqualsTheSphericalHarmonicsAndNegativeColoursAreCut) {
  for (const glm::dvec3& d :
       {glm::dvec3(1, 2, 3), glm::dvec3(-0.3, 0.1, -0.9), glm::dvec3(0, 0, 1), glm::dvec3(0, -1, 0)}) {
    const glm::dvec3 u = glm::normalize(d);
    for (unsigned l = 0; l <= 4; ++l) {
      for (int m = -static_cast<int>(l); m <= static_cast<int>(l); ++m) {
        const auto order = static_cast<unsigned>(std::abs(m));
        double basis = std::sph_legendre(l, order, std::acos(u.z));
        const double phi = std::atan2(u.y, u.x);
        if (m < 0) basis *= std::sqrt(2.0) * std::sin(order * phi);
        if (m > 0) basis *= std::sqrt(2.0) * std::cos(order * phi);
        float sh[75] = {};
        const auto k = static_cast<std::size_t>(static_cast<int>(l * l + l) + m);
        sh[3 * k] = 0.25f;
        sh[3 * k + 1] = -8.0f;
        const glm::dvec3 colour = reference_colour(sh, 4, u);
        EXPECT_NEAR(colour.x, std::max(0.0, 0.5 + 0.25 * basis), 1e-12) << l << ' ' << m;
        EXPECT_NEAR(colour.y, std::max(0.0, 0.5 - 8.0 * basis), 1e-11) << l << ' ' << m;
        EXPECT_DOUBLE_EQ(colour.z, 0.5);
      }
    }
  }
}

}  // namespace
}  // namespace grtx::frontend
