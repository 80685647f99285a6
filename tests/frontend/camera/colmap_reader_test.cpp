// SPDX-License-Identifier: Apache-2.0
// COLMAP's binary model, written by hand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "frontend/scene/scene_bytes.h"
#include "grtx/base/files_read.h"
#include "grtx/base/hash.h"
#include "parameter_names.h"

namespace grtx::frontend::test {
namespace {

using testing::HasSubstr;

struct ModelCase {
  int id;
  std::vector<double> parameters;  // no distortion
  double fx, fy, cx, cy;
  friend void PrintTo(const ModelCase& c, std::ostream* out) { *out << "model " << c.id; }
};

Bytes cameras_bin(int model, const std::vector<double>& parameters, std::uint64_t width = 640) {
  Bytes bytes;
  bytes.add(std::uint64_t{1}).add(std::int32_t{7}).add(std::int32_t{model}).add(width).add(std::uint64_t{480});
  for (const double p : parameters) bytes.add(p);
  return bytes;
}

Bytes& add_image(Bytes& bytes, const std::string& name, std::array<double, 4> wxyz, std::array<double, 3> t,
                 std::int32_t camera, std::uint64_t points) {
  bytes.add(std::int32_t{1});
  for (const double q : wxyz) bytes.add(q);
  for (const double v : t) bytes.add(v);
  bytes.add(camera).text(name).u8(0).add(points);
  for (std::uint64_t i = 0; i < points; ++i) bytes.add(1.0).add(2.0).add(std::int64_t{-1});
  return bytes;
}

Bytes images_bin() {
  Bytes bytes;
  bytes.add(std::uint64_t{2});
  add_image(bytes, "b.png", {1, 0, 0, 0}, {1, 2, 3}, 7, 2);
  const double h = std::sqrt(0.5);  // world to camera: 90 degrees about y
  return add_image(bytes, "a.png", {h, 0, h, 0}, {0, 0, 5}, 7, 0);
}

std::vector<Camera> load(const Bytes& cameras, const Bytes& images, const std::string& below = "") {
  const TemporaryPath folder("");
  std::filesystem::create_directories(folder.str() + below);
  write_file(folder.str() + below + "/cameras.bin", cameras.str());
  write_file(folder.str() + below + "/images.bin", images.str());
  FilesRead files;
  std::vector<Camera> made = load_cameras(folder.str(), files);
  EXPECT_EQ(files.files().size(), 2U);
  EXPECT_EQ(files.files().back().hash, xxh3(images.str()));
  return made;
}

std::string load_error(const Bytes& cameras, const Bytes& images) {
  return error_of([&] { load(cameras, images); });
}

TEST(ColmapReader, ReadsPosesSortedByName) {
  for (const std::string below : {"", "/sparse/0", "/sparse"}) {
    const std::vector<Camera> cameras = load(cameras_bin(1, {500, 510, 321, 241}), images_bin(), below);
    ASSERT_EQ(cameras.size(), 2u);
    EXPECT_EQ(cameras[0].name, "a.png");
    EXPECT_EQ(cameras[1].name, "b.png");
    EXPECT_EQ(cameras[1].position, glm::dvec3(-1, -2, -3));  // -R^T t
    EXPECT_EQ(cameras[1].rotation, glm::dmat3(1.0));
    // R maps world x to camera -z and world z to camera +x: forward is world -x.
    const Camera& turned = cameras[0];
    EXPECT_LT(glm::length(turned.rotation[2] - glm::dvec3(-1, 0, 0)), 1e-15);
    EXPECT_LT(glm::length(turned.rotation[0] - glm::dvec3(0, 0, 1)), 1e-15);
    EXPECT_LT(glm::length(turned.position - glm::dvec3(5, 0, 0)), 1e-14);
  }
}

class ColmapModel : public testing::TestWithParam<ModelCase> {};

TEST_P(ColmapModel, ReadsIntrinsics) {
  const ModelCase& c = GetParam();
  const Camera camera = load(cameras_bin(c.id, c.parameters), images_bin())[0];
  EXPECT_EQ(camera.width, 640u);
  EXPECT_EQ(camera.height, 480u);
  EXPECT_EQ(camera.fx, c.fx);
  EXPECT_EQ(camera.fy, c.fy);
  EXPECT_EQ(camera.cx, c.cx);
  EXPECT_EQ(camera.cy, c.cy);
  EXPECT_EQ(camera.projection == Projection::fisheye, c.id == 5);
}

TEST_P(ColmapModel, RefusesDistortion) {
  const ModelCase& c = GetParam();
  const std::size_t first = c.fx == c.fy ? 3 : 4;  // behind focal lengths and principal point
  for (std::size_t p = first; p < c.parameters.size(); ++p) {
    std::vector<double> distorted = c.parameters;
    distorted[p] = 1e-3;
    EXPECT_THAT(load_error(cameras_bin(c.id, distorted), images_bin()), HasSubstr("lens distortion"));
  }
}

INSTANTIATE_TEST_SUITE_P(Models, ColmapModel,
                         testing::Values(ModelCase{0, {500, 320, 240}, 500, 500, 320, 240},
                                         ModelCase{1, {500, 510, 320, 240}, 500, 510, 320, 240},
                                         ModelCase{2, {500, 320, 240, 0}, 500, 500, 320, 240},
                                         ModelCase{3, {500, 320, 240, 0, 0}, 500, 500, 320, 240},
                                         ModelCase{4, {500, 510, 320, 240, 0, 0, 0, 0}, 500, 510, 320, 240},
                                         ModelCase{5, {500, 510, 320, 240, 0, 0, 0, 0}, 500, 510, 320, 240},
                                         ModelCase{
                                             6, {500, 510, 320, 240, 0, 0, 0, 0, 0, 0, 0, 0}, 500, 510, 320, 240}),
                         grtx::test::PrintedName{});

TEST(ColmapReader, FisheyeAnglesFollowTheFocalLength) {
  const Camera camera = load(cameras_bin(5, {100, 100, 0.5, 0.5, 0, 0, 0, 0}), images_bin())[1];
  EXPECT_NEAR(camera.direction(30, 40).z, std::cos(0.5), 1e-12);
  EXPECT_EQ(camera.direction(320, 0), glm::dvec3(0.0));  // 3.2 rad is beyond straight back
  EXPECT_NEAR(camera.direction(310, 0).z, std::cos(3.1), 1e-12);
}

TEST(ColmapReader, BadContentNamesFileByteAndRule) {
  const Bytes good = cameras_bin(1, {500, 510, 320, 240});
  EXPECT_THAT(load_error(cameras_bin(7, {500, 510, 320, 240}), images_bin()), HasSubstr("model 7"));
  EXPECT_THAT(load_error(cameras_bin(-1, {500, 510, 320, 240}), images_bin()), HasSubstr("model -1"));
  EXPECT_THAT(load_error(cameras_bin(1, {0, 510, 320, 240}), images_bin()), HasSubstr("focal lengths"));
  EXPECT_THAT(load_error(cameras_bin(1, {500, 510, 320, 240}, 1u << 20), images_bin()), HasSubstr("1 to 65536"));
  EXPECT_THAT(load_error(cameras_bin(1, {500, 510, 320, 240}, 0), images_bin()), HasSubstr("1 to 65536"));
  Bytes longer = good;
  longer.u8(0);
  EXPECT_THAT(load_error(longer, images_bin()), HasSubstr("1 bytes behind its last entry"));
  Bytes image;
  image.add(std::uint64_t{1});
  Bytes other_camera = image, zero_rotation = image, many_points = image;
  EXPECT_THAT(load_error(good, add_image(other_camera, "a", {1, 0, 0, 0}, {0, 0, 0}, 8, 0)), HasSubstr("camera 8"));
  EXPECT_THAT(load_error(good, add_image(zero_rotation, "a", {0, 0, 0, 0}, {0, 0, 0}, 7, 0)), HasSubstr("quaternion"));
  many_points.add(std::int32_t{1}).add(1.0).add(0.0).add(0.0).add(0.0).add(0.0).add(0.0).add(0.0);
  many_points.add(std::int32_t{7}).text("a").u8(0).add(~std::uint64_t{0});
  EXPECT_THAT(load_error(good, many_points), HasSubstr("the file ends within an entry"));
  Bytes none;
  none.add(std::uint64_t{0});
  EXPECT_THAT(load_error(good, none), HasSubstr("has no images"));
  EXPECT_THROW(load_cameras(testing::TempDir()), Error);  // a folder without the two files
}

TEST(ColmapReader, EveryTruncationIsAnError) {
  const Bytes cameras = cameras_bin(4, {500, 510, 320, 240, 0, 0, 0, 0}), images = images_bin();
  for (std::size_t length = 0; length < cameras.size(); ++length) {
    Bytes part;
    part.text(std::string_view(cameras.str()).substr(0, length));
    EXPECT_THROW(load(part, images), Error) << length;
  }
  for (std::size_t length = 0; length < images.size(); ++length) {
    Bytes part;
    part.text(std::string_view(images.str()).substr(0, length));
    EXPECT_THROW(load(cameras, part), Error) << length;
  }
}

}  // namespace
}  // namespace grtx::frontend::test
