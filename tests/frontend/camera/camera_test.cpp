// SPDX-License-Identifier: Apache-2.0
// Primary rays of known pixels, and how resolution and field of view change them.
#include "grtx/frontend/camera/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "grtx/base/error.h"

namespace grtx::frontend {
namespace {

constexpr double kPi = std::numbers::pi;

Camera pinhole() {
  Camera camera;
  camera.height = 4;
  camera.width = 8;
  camera.cx = 4.0;
  camera.cy = 2.0;
  camera.fx = 4.0;
  camera.fy = 2.0;
  return camera;
}

void expect_direction(const glm::dvec3& actual, const glm::dvec3& expected) {
  for (glm::length_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(actual[axis], expected[axis], 1e-14);
}

TEST(Camera, OfOneHashSeeTheSame) {
  Camera renamed = pinhole();
  renamed.name = "another";
  renamed.position.x = -0.0;
  EXPECT_EQ(renamed.hash(), pinhole().hash());
  Camera moved = pinhole(), turned = pinhole(), fisheye = pinhole().as_fisheye(1.0);
  moved.position.z = 1e-9;
  turned.rotation[0] = -turned.rotation[0];
  for (const Camera& other : {moved, turned, fisheye, pinhole().resized(16, 8), pinhole().fov_scaled(1.01)}) {
    EXPECT_NE(other.hash(), pinhole().hash());
  }
  EXPECT_DOUBLE_EQ(pinhole().fov_scaled(0.5).fov_scaled(0.5).fov_scale, 0.25);
}

TEST(Camera, PinholeDirectionsOfKnownPixels) {
  const Camera camera = pinhole();
  expect_direction(camera.direction(0, 0), glm::normalize(glm::dvec3(-3.5 / 4.0, -1.5 / 2.0, 1.0)));
  expect_direction(camera.direction(7, 3), glm::normalize(glm::dvec3(3.5 / 4.0, 1.5 / 2.0, 1.0)));
  Camera shifted = camera;
  shifted.cx = 5.5;  // the centre of pixel (5, 1)
  shifted.cy = 1.5;
  expect_direction(shifted.direction(5, 1), {0.0, 0.0, 1.0});
}

TEST(Camera, RotationTurnsRightDownForwardIntoTheWorld) {
  Camera camera = pinhole();
  camera.cx = 0.5;
  camera.cy = 0.5;
  // Looks along world +x; right is world -y, down is world -z.
  camera.rotation = glm::dmat3(glm::dvec3(0, -1, 0), glm::dvec3(0, 0, -1), glm::dvec3(1, 0, 0));
  expect_direction(camera.direction(0, 0), {1.0, 0.0, 0.0});
  expect_direction(camera.direction(4, 0), glm::normalize(glm::dvec3(1.0, -1.0, 0.0)));
  expect_direction(camera.direction(0, 2), glm::normalize(glm::dvec3(1.0, 0.0, -1.0)));
}

TEST(Camera, ResizedKeepsBothFieldsOfView) {
  const Camera camera = pinhole(), small = camera.resized(4, 8);
  EXPECT_EQ(small.width, 4u);
  EXPECT_EQ(small.height, 8u);
  EXPECT_EQ(small.fx, 2.0);
  EXPECT_EQ(small.fy, 4.0);
  EXPECT_EQ(small.cx, 2.0);
  EXPECT_EQ(small.cy, 4.0);
  EXPECT_EQ(camera.width / camera.fx, small.width / small.fx);
  EXPECT_EQ(camera.height / camera.fy, small.height / small.fy);
  EXPECT_THROW(camera.resized(0, 8), Error);
  EXPECT_THROW(camera.resized(8, 0), Error);
}

TEST(Camera, FovScaleMultipliesTheTangentOfTheHalfAngle) {
  const Camera camera = pinhole(), wide = camera.fov_scaled(2.0);
  const glm::dvec3 before = camera.direction(7, 1), after = wide.direction(7, 1);
  EXPECT_NEAR(after.x / after.z, 2.0 * before.x / before.z, 1e-14);
  EXPECT_NEAR(after.y / after.z, 2.0 * before.y / before.z, 1e-14);
  EXPECT_EQ(wide.cx, camera.cx);
  for (const double factor : {0.0, -1.0, HUGE_VAL, std::nan("")}) EXPECT_THROW(camera.fov_scaled(factor), Error);
}

// Equidistant: the angle to the axis grows linearly with the distance from the middle; r = 1 at the image's edge.
TEST(Camera, FisheyeAnglesAreProportionalToTheRadius) {
  Camera camera = pinhole();
  camera.height = 8;
  camera.cy = 4.5;
  camera.cx = 4.5;
  camera = camera.as_fisheye(kPi);
  expect_direction(camera.direction(4, 4), {0.0, 0.0, 1.0});
  for (unsigned x = 4; x < 8; ++x) {
    const double theta = (x - 4.0) / 4.0 * (kPi / 2.0);
    expect_direction(camera.direction(x, 4), {std::sin(theta), 0.0, std::cos(theta)});
    expect_direction(camera.direction(4, x), {0.0, std::sin(theta), std::cos(theta)});
  }
  EXPECT_EQ(camera.direction(7, 7), glm::dvec3(0.0));  // r = 3 sqrt(2) / 4 > 1: outside the circle
  EXPECT_NE(camera.direction(6, 6), glm::dvec3(0.0));
}

TEST(Camera, FisheyeWithoutFocalLengthSpansTheImage) {
  Camera camera = pinhole();
  camera.projection = Projection::fisheye;
  camera.fisheye_fov = 2.0;
  camera.fx = camera.fy = 0.0;
  const Camera explicit_focal = pinhole().as_fisheye(2.0);
  for (unsigned y = 0; y < 4; ++y) {
    for (unsigned x = 0; x < 8; ++x) EXPECT_EQ(camera.direction(x, y), explicit_focal.direction(x, y));
  }
}

TEST(Camera, FisheyeFovScaleMultipliesTheAngle) {
  const Camera camera = pinhole().as_fisheye(1.0), wide = camera.fov_scaled(2.0);
  EXPECT_EQ(wide.fisheye_fov, 2.0);
  EXPECT_NEAR(std::acos(wide.direction(6, 2).z), 2.0 * std::acos(camera.direction(6, 2).z), 1e-12);
  EXPECT_THROW(camera.as_fisheye(0.0), Error);
  EXPECT_THROW(camera.as_fisheye(7.0), Error);
}

TEST(Camera, DirectionsHaveUnitLength) {
  const Camera cameras[] = {pinhole(), pinhole().as_fisheye(3.0)};
  for (const Camera& camera : cameras) {
    for (unsigned y = 0; y < 4; ++y) {
      for (unsigned x = 0; x < 8; ++x) {
        const double length = glm::length(camera.direction(x, y));
        EXPECT_TRUE(length == 0.0 || std::abs(length - 1.0) < 1e-15) << length;
      }
    }
  }
}

}  // namespace
}  // namespace grtx::frontend
