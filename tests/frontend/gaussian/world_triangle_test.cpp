// SPDX-License-Identifier: Apache-2.0
// The test against stored vertices: right where the answer is clear, watertight where triangles meet, and close to the
// canonical hit function in whole images.
#include "grtx/frontend/gaussian/world_triangle.h"
#include "grtx/frontend/accel/acceleration_structure.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <random>
#include <set>

#include "frontend/tracer/random_scene.h"
#include "frontend/tracer/render_helpers.h"
#include "grtx/frontend/gaussian/proxy.h"
#include "grtx/frontend/image/image.h"

namespace grtx::frontend {
namespace {

class WorldTriangle : public testing::Test {
 protected:
  float uniform(float low, float high) {
    return low + (high - low) * static_cast<float>(static_cast<double>(random_()) / 4294967296.0);
  }
  glm::vec3 point(float extent) {
    return {uniform(-extent, extent), uniform(-extent, extent), uniform(-extent, extent)};
  }
  std::mt19937 random_{7};
};

TEST_F(WorldTriangle, AgreesWithDoubleArithmetic) {
  unsigned hits = 0, clear = 0;
  for (int i = 0; i < 20000; ++i) {
    const glm::vec3 origin = point(3.0f), a = point(1.0f), b = point(1.0f), c = point(1.0f);
    const glm::vec3 direction = point(1.0f) - origin;
    const std::optional<float> t = ShearedRay(origin, direction).hit(a, b, c);
    // Möller and Trumbore in double; counter-clockwise from outside faces the ray.
    const glm::dvec3 d(direction), e1 = glm::dvec3(b) - glm::dvec3(a), e2 = glm::dvec3(c) - glm::dvec3(a);
    const glm::dvec3 s = glm::dvec3(origin) - glm::dvec3(a), p = glm::cross(d, e2), q = glm::cross(s, e1);
    const double determinant = glm::dot(e1, p);
    const double u = glm::dot(s, p) / determinant, v = glm::dot(d, q) / determinant;
    const double expected = glm::dot(e2, q) / determinant;
    const double margin = std::min({u, v, 1.0 - u - v, expected});
    if (std::fabs(margin) < 1e-4 || std::fabs(determinant) < 1e-4) continue;
    ++clear;
    ASSERT_EQ(t.has_value(), margin > 0.0 && determinant > 0.0) << i;
    if (!t) continue;
    ++hits;
    EXPECT_NEAR(static_cast<double>(*t), expected, 1e-4 * expected + 1e-5 / std::fabs(determinant)) << i;
  }
  EXPECT_GT(clear, 15000u);
  EXPECT_GT(hits, 500u);
}

// Rays at corners and edges of a closed solid: one front face at least is hit. On the seam itself it can be several.
TEST_F(WorldTriangle, NoRaySlipsBetweenTriangles) {
  unsigned doubled = 0;
  for (const ProxyKind kind : {ProxyKind::icosahedron20, ProxyKind::icosphere80}) {
    const Proxy proxy(kind);
    const auto& vertices = proxy.vertices();
    for (int i = 0; i < 5000; ++i) {
      const auto& triangle = proxy.triangles()[random_() % proxy.faces()];
      const float share = i % 3 == 0 ? 0.0f : i % 3 == 1 ? 0.5f : uniform(0.0f, 1.0f);
      const glm::vec3 seam = vertices[triangle[0]] * (1.0f - share) + vertices[triangle[1]] * share;
      const glm::vec3 inside = seam * 0.999f;  // so that the line passes through the solid whatever rounds
      const glm::vec3 origin = seam * uniform(1.5f, 4.0f);
      const ShearedRay ray(origin, inside - origin);
      unsigned hits = 0;
      for (const auto& [a, b, c] : proxy.triangles()) {
        hits += ray.hit(vertices[a], vertices[b], vertices[c]).has_value() ? 1 : 0;
      }
      ASSERT_GE(hits, 1u) << i;
      if (hits > 1) ++doubled;
    }
  }
  EXPECT_GT(doubled, 0u);
}

TEST_F(WorldTriangle, MissesBackFacesAndWhatLiesBehind) {
  const glm::vec3 a{-1, -1, 5}, b{1, -1, 5}, c{0, 1, 5};
  for (const float z : {0.0f, 4.0f}) {
    const ShearedRay ray({0, 0, z}, {0, 0, 1});
    EXPECT_FALSE(ray.hit(a, b, c));  // normal along the ray
    ASSERT_TRUE(ray.hit(a, c, b));
    EXPECT_EQ(*ray.hit(a, c, b), 5.0f - z);
  }
  EXPECT_FALSE(ShearedRay({0, 0, 6}, {0, 0, 1}).hit(a, c, b));
  EXPECT_FALSE(ShearedRay({0, 0, 0}, {0, 0, 1}).hit(a, a, a));
  EXPECT_FALSE(ShearedRay({0, 0, 0}, {1, 0, 0}).hit({1, 0, 0}, {2, 0, 0}, {2, 1, 0}));  // edge-on
}

TEST(WorldTriangleImage, IsCloseToTheCanonicalOne) {
  const Scene scene = test::random_scene(41);
  const Camera camera = test::front_camera(32, 32);
  for (const AccelKind kind : {AccelKind::tri20, AccelKind::tri80, AccelKind::tlas_tri20, AccelKind::tlas_tri80}) {
    const PreparedGaussians gaussians(scene, true);
    const AccelerationStructure accel(gaussians, {kind, 6, false});
    TracerOptions options;
    const RenderResult canonical = test::trace_scene(scene, camera, accel, gaussians, options);
    options.triangle_test = TriangleTest::world;
    const RenderResult world = test::trace_scene(scene, camera, accel, gaussians, options);
    EXPECT_GE(compare(canonical.image, world.image).psnr, 80.0) << accel_name(kind);
    EXPECT_EQ(canonical.counters.doubled, 0u);
    std::size_t other_sets = 0, doubled = 0;
    for (std::size_t p = 0; p < world.sequences.size(); ++p) {
      const std::set<std::uint32_t> expected(canonical.sequences[p].begin(), canonical.sequences[p].end());
      const std::set<std::uint32_t> actual(world.sequences[p].begin(), world.sequences[p].end());
      doubled += world.sequences[p].size() - actual.size();
      if (expected != actual) ++other_sets;
    }
    EXPECT_LE(other_sets, world.sequences.size() / 200) << accel_name(kind);
    EXPECT_LE(doubled, world.counters.doubled) << accel_name(kind);
    EXPECT_LE(world.counters.doubled, world.counters.processed / 1000) << accel_name(kind);
  }
}

// The z axis passes through the middle of an edge of the icosahedron: both of its triangles are hit.
TEST(WorldTriangleImage, DoubledHitsAreCounted) {
  Scene scene;
  scene.mean = {glm::vec3(0.0f)};
  scene.scale = {glm::vec3(0.3f)};
  scene.rotation = {glm::quat(1.0f, 0.0f, 0.0f, 0.0f)};
  scene.opacity = {0.5f};
  scene.sh = {0.1f, 0.2f, 0.3f};
  scene.sh_degree = 0;
  Camera camera;
  camera.width = camera.height = 1;
  camera.fx = camera.fy = 1.0;
  camera.cx = camera.cy = 0.5;
  camera.position = {0.0, 0.0, -4.0};
  TracerOptions options;
  options.triangle_test = TriangleTest::world;
  const RenderResult result = test::trace_scene(scene, camera, AccelKind::tri20, options);
  ASSERT_EQ(result.sequences[0].size(), 1u + result.counters.doubled);
  EXPECT_EQ(result.counters.doubled, 1u);
}

}  // namespace
}  // namespace grtx::frontend
