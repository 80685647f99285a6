// SPDX-License-Identifier: Apache-2.0
// Paths of light through the glass sphere and the mirror: Snell, total internal reflection, bounds.
#include "grtx/frontend/tracer/light_path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "grtx/base/error.h"
#include "grtx/frontend/numbers/counter_random.h"
#include "grtx/frontend/reference/reference_optics.h"

namespace grtx::frontend {
namespace {

using traces::RayKind;

OpticalObjects glass_ball(double index) {
  OpticalObjects objects;
  objects.glass = make_glass({0, 0, 0}, 1.0, index);
  return objects;
}

TEST(LightPath, GlassObeysSnellAtBothSurfacesAndLeavesTheSphere) {
  const OpticalObjects objects = glass_ball(1.5);
  for (const double height : {0.0, 0.2, 0.5, 0.9, 0.999}) {
    LightPath path(objects, {height, 0, -5}, {0, 0, 1});
    const double in = std::asin(height);
    EXPECT_NEAR(path.piece().limit, 5.0 - std::cos(in), 1e-12);
    ASSERT_TRUE(path.advance());
    EXPECT_EQ(path.piece().kind, RayKind::glass);
    const glm::dvec3 normal = glm::normalize(path.piece().origin);
    const double refracted = std::acos(std::min(1.0, -glm::dot(path.piece().direction, normal)));
    EXPECT_NEAR(std::sin(in), 1.5 * std::sin(refracted), 1e-7);
    EXPECT_NEAR(path.piece().limit, 2.0 * std::cos(refracted), 1e-7);  // the chord
    ASSERT_TRUE(path.advance());
    // Two equal deflections: the ray leaves turned by 2 (in - refracted) towards the axis.
    EXPECT_NEAR(std::acos(std::min(1.0, path.piece().direction.z)), 2.0 * (in - refracted), 1e-7);
    EXPECT_FALSE(path.piece().meets_surface());
    EXPECT_FALSE(path.advance());
    EXPECT_FALSE(path.truncated());
  }
}

TEST(LightPath, IndexOneBendsNothing) {
  const OpticalObjects objects = glass_ball(1.0);
  LightPath path(objects, {0.7, 0.1, -5}, {0, 0, 1});
  while (path.advance()) {
  }
  EXPECT_EQ(path.bounces(), 2u);
  EXPECT_NEAR(path.piece().direction.z, 1.0, 1e-15);
}

TEST(LightPath, LightInsideTheGlassReflectsTotallyUntilTheBound) {
  // In a sphere the angle of incidence never changes: what is reflected totally once is so for ever.
  OpticalObjects objects = glass_ball(1.5);
  objects.max_bounces = 5;
  LightPath path(objects, {0.9, 0, 0}, {0, 0, 1});  // sine of incidence 0.9 > 1 / 1.5
  for (unsigned i = 1; i <= 5; ++i) {
    ASSERT_TRUE(path.advance());
    EXPECT_NEAR(glm::length(path.piece().origin), 1.0, 1e-12);
    EXPECT_NEAR(path.piece().limit, 2.0 * std::sqrt(1.0 - 0.81), 1e-12);
  }
  EXPECT_FALSE(path.advance());
  EXPECT_TRUE(path.truncated());
  LightPath escapes(objects, {0.6, 0, 0}, {0, 0, 1});  // 0.6 < 1 / 1.5
  ASSERT_TRUE(escapes.advance());
  EXPECT_FALSE(escapes.piece().meets_surface());
}

TEST(LightPath, MirrorReflectsFromBothSidesInsideItsRectangleOnly) {
  OpticalObjects objects;
  objects.mirror = make_mirror({0, 0, 2}, {0, 3, -3}, 2.0, 1.0);
  for (const double side : {-1.0, 1.0}) {
    LightPath path(objects, {0.9, 0, 2.0 + 2.0 * side}, {0, 0, -side});
    EXPECT_NEAR(path.piece().limit, 2.0, 1e-15);
    ASSERT_TRUE(path.advance());
    EXPECT_EQ(path.piece().kind, RayKind::mirror);
    EXPECT_NEAR(path.piece().direction.y, side < 0 ? 1.0 : -1.0, 1e-15);
    EXPECT_FALSE(path.piece().meets_surface());
  }
  EXPECT_FALSE(LightPath(objects, {1.1, 0, 0}, {0, 0, 1}).piece().meets_surface());  // beside the width
  EXPECT_FALSE(
      LightPath(objects, {0, 0.4, 0}, {0, 0, 1}).piece().meets_surface());  // above the height: 0.4 > 0.5 cos 45
  EXPECT_FALSE(LightPath(objects, {0, 0, 0}, {0, 0, -1}).piece().meets_surface());  // behind the ray
  EXPECT_FALSE(LightPath(objects, {0, 5, 2}, {0, 1, 1}).piece().meets_surface());   // parallel to it
}

TEST(LightPath, AgreesWithTheReferencesOwnPath) {
  OpticalObjects objects = glass_ball(1.5);
  objects.mirror = make_mirror({0.5, 0, 2}, {-0.3, 0.1, -1}, 3.0, 3.0);
  objects.max_bounces = 6;
  const ReferenceOptics reference(objects, glm::dvec3(0.0));
  unsigned longest = 0;
  for (std::uint64_t i = 0; i < 2000; ++i) {
    CounterRandom random(7, 1, i);
    const glm::dvec3 origin = 3.0 * random.uniform() * random.direction();
    const glm::dvec3 direction = random.direction() * random.uniform(0.9, 1.1);
    LightPath path(objects, origin, direction);
    const auto pieces = reference.path(origin, direction);
    for (std::size_t p = 0; p < pieces.size(); ++p) {
      if (p > 0) {
        ASSERT_TRUE(path.advance()) << i;
      }
      ASSERT_LT(glm::length(path.piece().origin - pieces[p].origin), 1e-8) << i;
      ASSERT_LT(glm::length(path.piece().direction - pieces[p].direction), 1e-8) << i;
      ASSERT_EQ(path.piece().meets_surface(), std::isfinite(pieces[p].length)) << i;
      if (path.piece().meets_surface()) {
        ASSERT_NEAR(path.piece().limit, pieces[p].length, 1e-8) << i;
      }
    }
    ASSERT_FALSE(path.advance());
    longest = std::max(longest, path.bounces());
  }
  EXPECT_EQ(longest, 6u);
}

TEST(OpticalObjects, BadGeometryIsRefused) {
  EXPECT_THROW(make_glass({0, 0, 0}, 0.0, 1.5), Error);
  EXPECT_THROW(make_glass({0, NAN, 0}, 1.0, 1.5), Error);
  EXPECT_THROW(make_glass({0, 0, 0}, 1.0, 0.9), Error);
  EXPECT_THROW(make_mirror({0, 0, 0}, {0, 0, 0}, 1.0, 1.0), Error);
  EXPECT_THROW(make_mirror({0, 0, 0}, {0, 0, 1}, 1.0, -1.0), Error);
  OpticalObjects objects = glass_ball(1.5);
  objects.mirror = make_mirror({0, 0, 0.5}, {0, 0, 1}, 4.0, 4.0);
  EXPECT_THROW(check_apart(objects), Error);
  objects.mirror = make_mirror({0, 0, 1.5}, {0, 0, 1}, 4.0, 4.0);
  EXPECT_NO_THROW(check_apart(objects));
}

}  // namespace
}  // namespace grtx::frontend
