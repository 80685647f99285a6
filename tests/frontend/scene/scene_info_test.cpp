// SPDX-License-Identifier: Apache-2.0
// The description of a scene: boxes, percentiles, histogram and report, as numbers, text and JSON.
#include "grtx/frontend/scene/scene_info.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace grtx::frontend {
namespace {

using testing::HasSubstr;

// 101 Gaussians on a line: centres 0 .. 100 along x, scales (1, 2, 4) * (i + 1), opacity (i + 0.5) / 100, at most 1.
Scene line() {
  Scene scene;
  for (int i = 0; i <= 100; ++i) {
    const float f = static_cast<float>(i);
    scene.mean.emplace_back(f - 50.0f, 0.0f, 0.0f);
    scene.scale.emplace_back(2.0f * (f + 1.0f), 4.0f * (f + 1.0f), f + 1.0f);
    scene.rotation.emplace_back(1.0f, 0.0f, 0.0f, 0.0f);
    scene.opacity.push_back(std::min(1.0f, (f + 0.5f) / 100.0f));
    scene.sh.insert(scene.sh.end(), 3, 0.0f);
  }
  scene.offset = {50.0, 7.0, -8.0};
  scene.name = "line";
  scene.hash = "0123456789abcdef";
  scene.report.rows = 104;
  scene.report.dropped["NaN opacity"] = 3;
  return scene;
}

TEST(SceneInfo, PercentilesInterpolateBetweenRanks) {
  const SceneInfo info = describe(line());
  for (std::size_t p = 0; p < kInfoPercentiles.size(); ++p) {
    EXPECT_DOUBLE_EQ(info.scale_min[p], kInfoPercentiles[p] + 1.0);
    EXPECT_DOUBLE_EQ(info.scale_mid[p], 2.0 * (kInfoPercentiles[p] + 1.0));
    EXPECT_DOUBLE_EQ(info.scale_max[p], 4.0 * (kInfoPercentiles[p] + 1.0));
    EXPECT_DOUBLE_EQ(info.scale_ratio[p], 4.0);
  }
}

TEST(SceneInfo, BoxesAreInFileCoordinates) {
  const SceneInfo info = describe(line());
  EXPECT_EQ(info.centres->low, glm::dvec3(0.0, 7.0, -8.0));
  EXPECT_EQ(info.centres->high, glm::dvec3(100.0, 7.0, -8.0));
  EXPECT_NEAR(info.inner_centres->low.x, 0.05, 1e-12);  // 0.05 % of the ranks at either end
  EXPECT_NEAR(info.inner_centres->high.x, 99.95, 1e-12);
  EXPECT_NEAR(info.extent->high.x, 100.0 + 3.0 * 202.0, 1e-9);
  EXPECT_NEAR(info.extent->low.y, 7.0 - 3.0 * 404.0, 1e-9);
  EXPECT_NEAR(info.extent->high.z, -8.0 + 3.0 * 101.0, 1e-9);
}

TEST(SceneInfo, ExtentTurnsWithTheRotation) {
  Scene scene = line();
  const float h = std::sqrt(0.5f);
  for (glm::quat& q : scene.rotation) q = glm::quat(h, 0.0f, 0.0f, h);  // 90 degrees about z swaps x and y
  const SceneInfo info = describe(scene);
  EXPECT_NEAR(info.extent->high.x, 100.0 + 3.0 * 404.0, 1e-3);
  EXPECT_NEAR(info.extent->high.y, 7.0 + 3.0 * 202.0, 1e-3);
}

TEST(SceneInfo, OutliersLeaveTheInnerBox) {
  Scene scene = line();
  for (int i = 0; i < 5000; ++i) {
    scene.mean.push_back(glm::vec3(0.001f * static_cast<float>(i)));
    scene.scale.push_back(glm::vec3(1.0f));
    scene.rotation.emplace_back(1.0f, 0.0f, 0.0f, 0.0f);
    scene.opacity.push_back(1.0f);
  }
  scene.mean[7] = glm::vec3(0.0f, 1e6f, 0.0f);
  const SceneInfo info = describe(scene);
  EXPECT_EQ(info.centres->high.y, 1e6 + 7.0);
  EXPECT_LT(info.inner_centres->high.y, 20.0);
}

TEST(SceneInfo, OpacityTenths) {
  const SceneInfo info = describe(line());
  std::uint64_t sum = 0;
  for (const std::uint64_t count : info.opacity_tenths) sum += count;
  EXPECT_EQ(sum, 101u);
  EXPECT_EQ(info.opacity_tenths[9], 11u);  // 0.905 .. 0.995 and 1
  EXPECT_EQ(info.opacity_tenths[4], 10u);
}

TEST(SceneInfo, JsonHoldsTheNumbers) {
  const nlohmann::json document = nlohmann::json::parse(to_json(describe(line())));
  EXPECT_EQ(document["schema"], "grtx.info/1");
  EXPECT_EQ(document["rows"], 104);
  EXPECT_EQ(document["gaussians"], 101);
  EXPECT_EQ(document["sh_degree"], 0);
  EXPECT_EQ(document["offset"], nlohmann::json({50.0, 7.0, -8.0}));
  EXPECT_EQ(document["boxes"]["centres"]["high"][0], 100.0);
  EXPECT_EQ(document["scale"]["max"]["p50"], 204.0);
  EXPECT_EQ(document["opacity_tenths"].size(), 10u);
  EXPECT_EQ(document["dropped"]["NaN opacity"], 3);
  EXPECT_TRUE(document["clamped"].empty());
}

TEST(SceneInfo, TextHoldsTheNumbers) {
  const std::string text = to_text(describe(line()));
  EXPECT_THAT(text, HasSubstr("101 of 104 rows"));
  EXPECT_THAT(text, HasSubstr("(0, 7, -8) to (100, 7, -8)"));
  EXPECT_THAT(text, HasSubstr("3  NaN opacity"));
  EXPECT_THAT(text, HasSubstr("0123456789abcdef"));
}

TEST(SceneInfo, EmptySceneHasNoBoxes) {
  const SceneInfo info = describe(Scene{});
  EXPECT_FALSE(info.centres.has_value());
  EXPECT_TRUE(nlohmann::json::parse(to_json(info))["boxes"]["centres"].is_null());
  EXPECT_THAT(to_text(info), HasSubstr("empty scene"));
}

}  // namespace
}  // namespace grtx::frontend
