// SPDX-License-Identifier: Apache-2.0
// NeRF transforms.json: OpenGL axes, focal lengths from angles or pixels, image sizes from keys or PNG files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "frontend/scene/scene_bytes.h"

namespace grtx::frontend::test {
namespace {

using testing::HasSubstr;

// Columns: right +x, up +z, back -y; so down is -z and forward +y. Centre (1, 2, 3).
const std::string kFrame =
    R"({"file_path":"./train/r_0","transform_matrix":[[1,0,0,1],[0,0,-1,2],[0,1,0,3],[0,0,0,1]]})";

TEST(TransformsJson, TurnsOpenGlAxesAndAnglesIntoTheInternalCamera) {
  const std::vector<Camera> cameras =
      cameras_from(R"({"camera_angle_x":1.2,"w":800,"h":600,"frames":[)" + kFrame + "," + kFrame + "]}");
  ASSERT_EQ(cameras.size(), 2u);
  const Camera& camera = cameras[0];
  EXPECT_EQ(camera.name, "./train/r_0");
  EXPECT_EQ(camera.position, glm::dvec3(1, 2, 3));
  EXPECT_EQ(camera.rotation[0], glm::dvec3(1, 0, 0));
  EXPECT_EQ(camera.rotation[1], glm::dvec3(0, 0, -1));
  EXPECT_EQ(camera.rotation[2], glm::dvec3(0, 1, 0));
  EXPECT_DOUBLE_EQ(camera.fx, 400.0 / std::tan(0.6));
  EXPECT_EQ(camera.fy, camera.fx);
  EXPECT_EQ(camera.cx, 400.0);
  EXPECT_EQ(camera.cy, 300.0);
}

TEST(TransformsJson, FramesOverrideKeysOfTheFile) {
  std::string own = kFrame;
  own.insert(1, R"("fl_x":90,"cy":33,"h":70,)");
  const std::vector<Camera> cameras =
      cameras_from(R"({"fl_x":100,"fl_y":110,"cx":41,"cy":31,"w":80,"h":60,"frames":[)" + kFrame + "," + own + "]}");
  EXPECT_EQ(cameras[0].fx, 100.0);
  EXPECT_EQ(cameras[0].fy, 110.0);
  EXPECT_EQ(cameras[0].cx, 41.0);
  EXPECT_EQ(cameras[0].cy, 31.0);
  EXPECT_EQ(cameras[0].height, 60u);
  EXPECT_EQ(cameras[1].fx, 90.0);
  EXPECT_EQ(cameras[1].fy, 110.0);
  EXPECT_EQ(cameras[1].cy, 33.0);
  EXPECT_EQ(cameras[1].height, 70u);
}

TEST(TransformsJson, TakesTheSizeFromThePngBesideTheFile) {
  const TemporaryPath folder("");
  std::filesystem::create_directories(folder.str() + "/train");
  Bytes png;
  png.text("\x89PNG\r\n\x1a\n").add_swapped(std::uint32_t{13}).text("IHDR");
  png.add_swapped(std::uint32_t{300}).add_swapped(std::uint32_t{200});
  write_file(folder.str() + "/train/r_0.png", png.str());
  write_file(folder.str() + "/transforms.json", R"({"camera_angle_x":1.0,"frames":[)" + kFrame + "]}");
  const std::vector<Camera> cameras = load_cameras(folder.str() + "/transforms.json");
  EXPECT_EQ(cameras[0].width, 300u);
  EXPECT_EQ(cameras[0].height, 200u);
}

TEST(TransformsJson, FisheyeIsEquidistant) {
  const std::vector<Camera> cameras =
      cameras_from(R"({"camera_model":"OPENCV_FISHEYE","k1":0,"fl_x":50,"w":101,"h":101,"frames":[)" + kFrame + "]}");
  EXPECT_EQ(cameras[0].projection, Projection::fisheye);
  const glm::dvec3 forward = cameras[0].rotation[2];
  EXPECT_NEAR(std::acos(glm::dot(cameras[0].direction(75, 50), forward)), 0.5, 1e-12);  // 25 pixels at 50 a radian
}

TEST(TransformsJson, RefusesWhatItCannotRender) {
  const auto with = [](const std::string& keys) { return "{" + keys + "\"frames\":[" + kFrame + "]}"; };
  EXPECT_THAT(camera_error(with(R"("camera_angle_x":1,)")), HasSubstr("frame 0: needs \"w\" and \"h\""));
  EXPECT_THAT(camera_error(with(R"("w":8,"h":8,)")), HasSubstr("\"fl_x\" or \"camera_angle_x\""));
  EXPECT_THAT(camera_error(with(R"("w":8,"h":8,"fl_x":1,"k1":0.1,)")), HasSubstr("distortion"));
  EXPECT_THAT(camera_error(with(R"("w":8,"h":8,"fl_x":1,"camera_model":"SPHERICAL",)")), HasSubstr("SPHERICAL"));
  EXPECT_THAT(camera_error(with(R"("w":8,"h":8,"camera_angle_x":0,)")), HasSubstr("focal lengths"));
  EXPECT_THAT(camera_error(with(R"("w":8,"h":8,"fl_x":"1",)")), HasSubstr("\"fl_x\" must be a number"));
  EXPECT_THAT(camera_error(R"({"w":8,"h":8,"fl_x":1,"frames":[{}]})"), HasSubstr("needs the key \"transform_matrix\""));
  EXPECT_THAT(camera_error(R"({"frames":[3]})"), HasSubstr("frame 0"));
  EXPECT_THAT(camera_error(R"({"frames":[]})"), HasSubstr("has no cameras"));
  EXPECT_THAT(camera_error(R"({"w":8,"h":8,"fl_x":1,"frames":[{"transform_matrix":[[2,0,0,0],[0,2,0,0],[0,0,2,0]]}]})"),
              HasSubstr("orthonormal"));
}

}  // namespace
}  // namespace grtx::frontend::test
