// SPDX-License-Identifier: Apache-2.0
// Which rows become Gaussians, and how they are activated, clamped and recentred.
#include "grtx/frontend/scene/scene_rows.h"
#include "parameter_names.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <string>

namespace grtx::frontend {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

RawRows plain_rows(std::size_t count) {
  RawRows rows;
  for (std::size_t i = 0; i < count; ++i) {
    rows.x.push_back(static_cast<double>(i));
    rows.y.push_back(0.0);
    rows.z.push_back(0.0);
    rows.log_scale.insert(rows.log_scale.end(), {-1.0f, -2.0f, -3.0f});
    rows.rotation.insert(rows.rotation.end(), {1.0f, 0.0f, 0.0f, 0.0f});
    rows.opacity_logit.push_back(0.0f);
    rows.sh.insert(rows.sh.end(), {0.1f, 0.2f, 0.3f});
  }
  return rows;
}

using Counts = std::map<std::string, std::uint64_t>;

struct DropCase {
  const char* reason;
  void (*damage)(RawRows&);
  friend void PrintTo(const DropCase& c, std::ostream* out) { *out << c.reason; }
};
class SceneRowsDrop : public testing::TestWithParam<DropCase> {};

// Row 1 of 3 is damaged: it goes, the others stay, the count names the reason.
TEST_P(SceneRowsDrop, DropsAndCounts) {
  RawRows rows = plain_rows(3);
  GetParam().damage(rows);
  const Scene scene = make_scene(rows, "n", "h");
  EXPECT_EQ(scene.report.rows, 3u);
  ASSERT_EQ(scene.size(), 2u);
  EXPECT_EQ(scene.report.dropped, (Counts{{GetParam().reason, 1}}));
  EXPECT_TRUE(scene.report.clamped.empty());
  EXPECT_EQ(scene.offset.x, 1.0);  // median of 0 and 2
  EXPECT_EQ(scene.mean[0].x, -1.0f);
  EXPECT_EQ(scene.mean[1].x, 1.0f);
  EXPECT_EQ(scene.sh.size(), 6u);
}

INSTANTIATE_TEST_SUITE_P(
    Reasons, SceneRowsDrop,
    testing::Values(DropCase{"non-finite position", [](RawRows& r) { r.y[1] = std::nan(""); }},
                    DropCase{"non-finite position", [](RawRows& r) { r.z[1] = HUGE_VAL; }},
                    DropCase{"position beyond 1e37", [](RawRows& r) { r.x[1] = -1e38; }},
                    DropCase{"non-finite scale", [](RawRows& r) { r.log_scale[3] = kNan; }},
                    DropCase{"non-finite scale", [](RawRows& r) { r.log_scale[5] = -kInfinity; }},
                    DropCase{"exp(scale) beyond 1e37", [](RawRows& r) { r.log_scale[4] = 85.2f; }},
                    DropCase{"exp(scale) beyond 1e37", [](RawRows& r) { r.log_scale[4] = 3e38f; }},
                    DropCase{"non-finite rotation", [](RawRows& r) { r.rotation[7] = kInfinity; }},
                    DropCase{"quaternion norm < 1e-12", [](RawRows& r) { r.rotation[4] = 0.0f; }},
                    DropCase{"quaternion norm < 1e-12", [](RawRows& r) { r.rotation[4] = 9e-13f; }},
                    DropCase{"NaN opacity", [](RawRows& r) { r.opacity_logit[1] = kNan; }},
                    DropCase{"opacity logit -infinity", [](RawRows& r) { r.opacity_logit[1] = -kInfinity; }},
                    DropCase{"non-finite SH coefficient", [](RawRows& r) { r.sh[5] = kNan; }},
                    DropCase{"non-finite SH coefficient", [](RawRows& r) { r.sh[3] = kInfinity; }}),
    grtx::test::NumberedName{});

TEST(SceneRows, SmallScalesAreClampedAndCountedPerRow) {
  RawRows rows = plain_rows(2);
  rows.log_scale[0] = rows.log_scale[1] = -80.0f;
  const Scene scene = make_scene(rows, "n", "h");
  EXPECT_EQ(scene.scale[0].x, 1e-6f);
  EXPECT_EQ(scene.scale[0].y, 1e-6f);
  EXPECT_EQ(scene.scale[0].z, static_cast<float>(std::exp(-3.0)));
  EXPECT_EQ(scene.report.clamped, (Counts{{"exp(scale) < 1e-6, set to 1e-6", 1}}));
}

TEST(SceneRows, ScaleJustBelowOverflowIsKept) {
  RawRows rows = plain_rows(1);
  rows.log_scale[0] = 85.0f;
  EXPECT_EQ(make_scene(rows, "n", "h").scale[0].x, static_cast<float>(std::exp(85.0)));
}

TEST(SceneRows, OpacityIsTheSigmoidOfTheLogit) {
  RawRows rows = plain_rows(5);
  rows.opacity_logit = {0.0f, 2.0f, kInfinity, -3e38f, -5.6f};
  const Scene scene = make_scene(rows, "n", "h");
  EXPECT_EQ(scene.opacity[0], 0.5f);
  EXPECT_EQ(scene.opacity[1], static_cast<float>(1.0 / (1.0 + std::exp(-2.0))));
  EXPECT_EQ(scene.opacity[2], 1.0f);
  EXPECT_EQ(scene.opacity[3], 0.0f);
  EXPECT_LT(scene.opacity[4], 1.0f / 255.0f);
  EXPECT_EQ(scene.report.clamped, (Counts{{"opacity logit +infinity, opacity 1", 1}}));
  EXPECT_EQ(scene.report.noticed, (Counts{{"opacity <= 1/255 (can never be accepted)", 2}}));
}

TEST(SceneRows, QuaternionsAreNormalisedAndCountedWhenOff) {
  RawRows rows = plain_rows(3);
  rows.rotation = {1.0005f, 0.0f, 0.0f, 0.0f, 0.0f, 3e-6f, 0.0f, -4e-6f, 1e30f, 1e30f, -1e30f, 1e30f};
  const Scene scene = make_scene(rows, "n", "h");
  EXPECT_EQ(scene.rotation[0], glm::quat(1.0f, 0.0f, 0.0f, 0.0f));
  EXPECT_FLOAT_EQ(scene.rotation[1].x, 0.6f);
  EXPECT_FLOAT_EQ(scene.rotation[1].z, -0.8f);
  EXPECT_EQ(scene.rotation[2], glm::quat(0.5f, 0.5f, -0.5f, 0.5f));
  EXPECT_EQ(scene.report.noticed, (Counts{{"quaternion norm off 1 by more than 1e-3", 2}}));
}

TEST(SceneRows, CoincidentCentresCountAllButTheFirst) {
  RawRows rows = plain_rows(6);
  rows.x = {1.0, 1.0, 5.0, 1.0, 5.0, 7.0};
  rows.z = {0.0, -0.0, 0.0, 0.0, 1.0, 0.0};
  EXPECT_EQ(make_scene(rows, "n", "h").report.noticed, (Counts{{"coincident centres", 2}}));
}

TEST(SceneRows, RecentresOnTheMedianRoundedToFloat) {
  RawRows rows = plain_rows(4);
  rows.x = {100.0, 1.0, 3.0, 2.0};  // the mean of 2 and 3
  rows.y = {0.1, 0.1, 0.1, 0.1};
  const Scene scene = make_scene(rows, "n", "h");
  EXPECT_EQ(scene.offset.x, 2.5);
  EXPECT_EQ(scene.offset.y, static_cast<double>(0.1f));
  EXPECT_EQ(scene.mean[0], glm::vec3(97.5f, static_cast<float>(0.1 - static_cast<double>(0.1f)), 0.0f));
}

TEST(SceneRows, AllZeroRowsAndEmptyScenesWork) {
  RawRows rows = plain_rows(1);
  rows.rotation.assign(4, 0.0f);
  rows.log_scale.assign(3, 0.0f);
  const Scene scene = make_scene(rows, "name", "hash");
  EXPECT_EQ(scene.size(), 0u);
  EXPECT_EQ(scene.report.dropped, (Counts{{"quaternion norm < 1e-12", 1}}));
  EXPECT_EQ(scene.offset, glm::dvec3(0.0));
  EXPECT_EQ(scene.name, "name");
  EXPECT_EQ(scene.hash, "hash");
}

}  // namespace
}  // namespace grtx::frontend
