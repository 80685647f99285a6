// SPDX-License-Identifier: Apache-2.0
// The cameras.json of 3DGS: what is read, what is refused, and that writing and reading gives the same cameras.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/quaternion.hpp>

#include "frontend/scene/scene_bytes.h"
#include "parameter_names.h"

namespace grtx::frontend::test {
namespace {

using testing::HasSubstr;

const std::string kEntry = R"({"id":0,"img_name":"a.jpg","width":640,"height":480,"position":[1,2,3],)"
                           R"("rotation":[[0,0,1],[-1,0,0],[0,-1,0]],"fy":500.5,"fx":400})";

TEST(CamerasJson, ReadsPositionRotationRowsAndFocalLengths) {
  const std::vector<Camera> cameras = cameras_from("[" + kEntry + "]");
  ASSERT_EQ(cameras.size(), 1u);
  const Camera& camera = cameras[0];
  EXPECT_EQ(camera.name, "a.jpg");
  EXPECT_EQ(camera.width, 640u);
  EXPECT_EQ(camera.height, 480u);
  EXPECT_EQ(camera.position, glm::dvec3(1, 2, 3));
  EXPECT_EQ(camera.fx, 400.0);
  EXPECT_EQ(camera.fy, 500.5);
  EXPECT_EQ(camera.cx, 320.0);  // no principal point: the middle
  EXPECT_EQ(camera.cy, 240.0);
  // The file stores rows; the columns are right, down, forward.
  EXPECT_EQ(camera.rotation[0], glm::dvec3(0, -1, 0));
  EXPECT_EQ(camera.rotation[1], glm::dvec3(0, 0, -1));
  EXPECT_EQ(camera.rotation[2], glm::dvec3(1, 0, 0));
}

TEST(CamerasJson, WritingAndReadingGivesTheSameCameras) {
  std::vector<Camera> cameras;
  for (int i = 0; i < 4; ++i) {
    Camera camera;
    camera.name = "view \"" + std::to_string(i) + "\"";
    camera.width = 100u + static_cast<unsigned>(i);
    camera.height = 77;
    camera.position = {0.1 * i, -1.0 / 3.0, 1e7 + 0.123456789};
    camera.rotation = glm::mat3_cast(glm::normalize(glm::dquat(1.0, 0.3 * i, -0.7, 0.2)));
    camera.fx = 123.456;
    camera.fy = 1.0 / 7.0;
    camera.cx = i == 0 ? 50.0 : 41.3;
    camera.cy = 38.5;
    cameras.push_back(i == 3 ? camera.as_fisheye(2.5) : camera);
  }
  const TemporaryPath path(".json");
  write_cameras_json(path.str(), cameras);
  const std::vector<Camera> again = load_cameras(path.str());
  ASSERT_EQ(again.size(), cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Camera &a = cameras[i], &b = again[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.width, b.width);
    EXPECT_EQ(a.height, b.height);
    EXPECT_EQ(a.position, b.position);
    EXPECT_EQ(a.rotation, b.rotation);
    EXPECT_EQ(a.fx, b.fx);
    EXPECT_EQ(a.fy, b.fy);
    EXPECT_EQ(a.cx, b.cx);
    EXPECT_EQ(a.cy, b.cy);
    EXPECT_EQ(a.projection, b.projection);
    EXPECT_EQ(a.fisheye_fov, b.fisheye_fov);
  }
}

TEST(CamerasJson, FisheyeNeedsNoFocalLength) {
  const std::vector<Camera> cameras =
      cameras_from(R"([{"width":10,"height":20,"position":[0,0,0],"rotation":[[1,0,0],[0,1,0],[0,0,1]],)"
                   R"("projection":"fisheye","fisheye_fov":2.0}])");
  EXPECT_EQ(cameras[0].fx, 5.0);
  EXPECT_EQ(cameras[0].fy, 10.0);
  EXPECT_EQ(cameras[0].name, "camera_0");
}

struct BadCase {
  const char* what;
  const char* replacement;
  const char* message;
  friend void PrintTo(const BadCase& c, std::ostream* out) { *out << c.what << " -> " << c.replacement; }
};
class CamerasJsonBad : public testing::TestWithParam<BadCase> {};

// The second of two cameras is damaged: the message names it and the rule.
TEST_P(CamerasJsonBad, NamesCameraAndRule) {
  const auto [what, replacement, message] = GetParam();
  std::string bad = kEntry;
  const std::size_t at = bad.find(what);
  ASSERT_NE(at, std::string::npos);
  bad.replace(at, std::strlen(what), replacement);
  EXPECT_THAT(camera_error("[" + kEntry + "," + bad + "]"), HasSubstr(message));
}

INSTANTIATE_TEST_SUITE_P(
    Cases, CamerasJsonBad,
    testing::Values(BadCase{"\"fx\"", "\"f_x\"", "camera 1: needs the key \"fx\""},
                    BadCase{"\"width\":640,", "", "camera 1: needs the key \"width\""},
                    BadCase{"\"rotation\"", "\"turn\"", "camera 1: needs the key \"rotation\""},
                    BadCase{"640", "0", "width and height must be 1 to 65536 pixels"},
                    BadCase{"640", "-640", "\"width\" must be a whole number"},
                    BadCase{"640", "64.5", "\"width\" must be a whole number"},
                    BadCase{"640", "1e9", "\"width\" must be a whole number"},
                    BadCase{"640", "\"640\"", "\"width\" must be a number"},
                    BadCase{"500.5", "0", "focal lengths must be positive"},
                    BadCase{"500.5", "-3", "focal lengths must be positive"},
                    BadCase{"[1,2,3]", "[1,2]", "\"position\" must be an array of 3 numbers"},
                    BadCase{"[1,2,3]", "[1,2,1e300]", "the position must be finite in fp32"},
                    BadCase{"[1,2,3]", "[1,2,null]", "\"position\" must be an array of 3 numbers"},
                    BadCase{"[0,0,1]", "[0,0,1.01]", "orthonormal"}, BadCase{"[0,0,1]", "[0,0,-1]", "mirror"},
                    BadCase{"[0,0,1]", "[0,0]", "\"rotation\" must be 3 arrays of 3 numbers"},
                    BadCase{"[0,-1,0]]", "[0,-1,0]],\"projection\":\"round\"", "\"pinhole\" or \"fisheye\""},
                    BadCase{"[0,-1,0]]", "[0,-1,0]],\"projection\":\"fisheye\"", "\"fisheye_fov\""},
                    BadCase{"[0,-1,0]]", "[0,-1,0]],\"projection\":\"fisheye\",\"fisheye_fov\":7", "2 pi"},
                    BadCase{"\"a.jpg\"", "5", "\"img_name\" must be a string"},
                    BadCase{"[1,2,3]", "[1,2,1e999]", "not readable JSON"}),
    grtx::test::NumberedName{});

TEST(CamerasJson, BadJsonNamesTheByte) {
  EXPECT_THAT(camera_error("[{\"width\": 12,]"), HasSubstr("byte 15: is not valid JSON"));
  EXPECT_THAT(camera_error(""), HasSubstr("is not valid JSON"));
  EXPECT_THAT(camera_error("[1]"), HasSubstr("camera 0: must be an object"));
  EXPECT_THAT(camera_error("[]"), HasSubstr("has no cameras"));
  EXPECT_THAT(camera_error("{}"), HasSubstr("\"frames\""));
  EXPECT_THAT(camera_error("3"), HasSubstr("\"frames\""));
  EXPECT_THROW(load_cameras("no/such/cameras.json"), Error);
}

TEST(CamerasJson, EveryTruncationIsAnError) {
  const std::string whole = "[" + kEntry + "]";
  for (std::size_t length = 0; length < whole.size(); ++length) {
    EXPECT_THROW(cameras_from(std::string_view(whole).substr(0, length)), Error) << length;
  }
}

}  // namespace
}  // namespace grtx::frontend::test
