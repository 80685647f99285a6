// SPDX-License-Identifier: Apache-2.0
// .splat: 32 bytes per Gaussian, recognised from plausible content alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "frontend/scene/scene_bytes.h"

namespace grtx::frontend::test {
namespace {

Bytes& add_row(Bytes& bytes, std::array<double, 3> position, std::array<double, 3> scale,
               std::array<unsigned, 4> colour, std::array<unsigned, 4> rotation) {
  for (const double p : position) bytes.f32(p);
  for (const double s : scale) bytes.f32(s);
  for (const unsigned c : colour) bytes.u8(c);
  for (const unsigned r : rotation) bytes.u8(r);
  return bytes;
}

TEST(SplatReader, DecodesRowsWrittenByHand) {
  Bytes bytes;
  add_row(bytes, {1.0, 2.0, 3.0}, {0.5, 0.25, 4.0}, {0, 128, 255, 51}, {255, 128, 128, 128});
  add_row(bytes, {-1.0, 2.0, 3.0}, {0.5, 0.0, 4.0}, {0, 0, 0, 255}, {128, 128, 0, 128});
  const Scene scene = scene_from(bytes.str());
  ASSERT_EQ(scene.size(), 2u);
  EXPECT_EQ(scene.sh_degree, 0u);
  EXPECT_EQ(centre_of(scene, 0), glm::dvec3(1.0, 2.0, 3.0));
  EXPECT_FLOAT_EQ(scene.scale[0].x, 0.5f);
  EXPECT_FLOAT_EQ(scene.scale[0].y, 0.25f);
  EXPECT_FLOAT_EQ(scene.scale[0].z, 4.0f);
  EXPECT_FLOAT_EQ(scene.opacity[0], 0.2f);
  // colour = byte / 255 = 0.5 + C0 f_dc
  EXPECT_NEAR(0.5 + 0.28209479177387814 * scene.sh[0], 0.0, 1e-6);
  EXPECT_NEAR(0.5 + 0.28209479177387814 * scene.sh[1], 128.0 / 255.0, 1e-6);
  EXPECT_NEAR(0.5 + 0.28209479177387814 * scene.sh[2], 1.0, 1e-6);
  EXPECT_EQ(scene.rotation[0], glm::quat(1.0f, 0.0f, 0.0f, 0.0f));
  EXPECT_EQ(scene.rotation[1], glm::quat(0.0f, 0.0f, -1.0f, 0.0f));
  EXPECT_EQ(scene.opacity[1], 1.0f);
  EXPECT_EQ(scene.scale[1].y, 1e-6f);  // linear scale 0
  EXPECT_EQ(scene.report.clamped.size(), 2u);
}

TEST(SplatReader, DropsTransparentRowsAndZeroQuaternions) {
  Bytes bytes;
  add_row(bytes, {0, 0, 0}, {1, 1, 1}, {9, 9, 9, 9}, {255, 128, 128, 128});
  add_row(bytes, {0, 0, 0}, {1, 1, 1}, {9, 9, 9, 0}, {255, 128, 128, 128});
  add_row(bytes, {0, 0, 0}, {1, 1, 1}, {9, 9, 9, 9}, {128, 128, 128, 128});
  const Scene scene = scene_from(bytes.str());
  EXPECT_EQ(scene.size(), 1u);
  EXPECT_EQ(scene.report.dropped.at("opacity logit -infinity"), 1u);
  EXPECT_EQ(scene.report.dropped.at("quaternion norm < 1e-12"), 1u);
}

TEST(SplatReader, RefusesSizesThatAreNoMultipleOf32) {
  Bytes bytes;
  add_row(bytes, {0, 0, 0}, {1, 1, 1}, {9, 9, 9, 9}, {255, 128, 128, 128});
  for (std::size_t length = 0; length < 32; ++length) {
    EXPECT_THROW(scene_from(std::string_view(bytes.str()).substr(0, length)), Error);
  }
  EXPECT_THROW(scene_from(bytes.str() + "x"), Error);
}

}  // namespace
}  // namespace grtx::frontend::test
