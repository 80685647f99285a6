// SPDX-License-Identifier: Apache-2.0
// INRIA .ply files give the same scene in every encoding, property order and type that the format allows.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "frontend/scene/ply_bytes.h"
#include "parameter_names.h"

namespace grtx::frontend::test {
namespace {

TEST(PlyReader, DecodesOneGaussianWrittenByHand) {
  Bytes bytes;
  bytes.text(
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\n"
      "property float x\nproperty float y\nproperty float z\n"
      "property float f_dc_0\nproperty float f_dc_1\nproperty float f_dc_2\n"
      "property float opacity\nproperty float scale_0\nproperty float scale_1\nproperty float scale_2\n"
      "property float rot_0\nproperty float rot_1\nproperty float rot_2\nproperty float rot_3\nend_header\n");
  bytes.f32(1.5).f32(-2.25).f32(3.0).f32(0.1).f32(0.2).f32(0.3);
  bytes.f32(std::log(3.0)).f32(std::log(0.5)).f32(0.0).f32(std::log(2.0));  // opacity 0.75; scales 0.5, 1, 2
  bytes.f32(0.0).f32(3.0).f32(0.0).f32(4.0);                                // w x y z, norm 5
  const Scene scene = scene_from(bytes.str());
  ASSERT_EQ(scene.size(), 1u);
  EXPECT_EQ(scene.sh_degree, 0u);
  EXPECT_EQ(centre_of(scene, 0), glm::dvec3(1.5, -2.25, 3.0));
  EXPECT_NEAR(scene.opacity[0], 0.75f, 1e-6f);
  EXPECT_NEAR(scene.scale[0].x, 0.5f, 1e-6f);
  EXPECT_NEAR(scene.scale[0].y, 1.0f, 1e-6f);
  EXPECT_NEAR(scene.scale[0].z, 2.0f, 1e-6f);
  EXPECT_EQ(scene.rotation[0].w, 0.0f);
  EXPECT_EQ(scene.rotation[0].x, 0.6f);
  EXPECT_EQ(scene.rotation[0].y, 0.0f);
  EXPECT_EQ(scene.rotation[0].z, 0.8f);
  EXPECT_EQ(scene.sh, (std::vector<float>{0.1f, 0.2f, 0.3f}));
  EXPECT_EQ(scene.report.rows, 1u);
  EXPECT_EQ(scene.hash.size(), 16u);
}

struct DegreeCase {
  unsigned f_rest, degree;
  friend void PrintTo(const DegreeCase& c, std::ostream* out) { *out << "degree " << c.degree; }
};
class PlyReaderDegree : public testing::TestWithParam<DegreeCase> {};

// f_rest is channel-major in the file: coefficient j >= 1 of channel c is f_rest[c (K - 1) + j - 1].
TEST_P(PlyReaderDegree, TurnsChannelMajorIntoCoefficientMajor) {
  const auto [f_rest, degree] = GetParam();
  PlyTable table = sample_table(f_rest, 3);
  for (auto& row : table.rows) {
    for (unsigned i = 0; i < f_rest; ++i) row[9 + i] = static_cast<float>(i);
  }
  const Scene scene = scene_from(binary_ply(table));
  ASSERT_EQ(scene.sh_degree, degree);
  const unsigned coefficients = (degree + 1) * (degree + 1);
  ASSERT_EQ(scene.sh.size(), 3u * coefficients * 3u);
  for (unsigned g = 0; g < 3; ++g) {
    for (unsigned c = 0; c < 3; ++c) {
      EXPECT_EQ(scene.sh[g * coefficients * 3 + c], table.rows[g][6 + c]) << "constant term";
      for (unsigned j = 1; j < coefficients; ++j) {
        EXPECT_EQ(scene.sh[(g * coefficients + j) * 3 + c], static_cast<float>(c * (coefficients - 1) + j - 1));
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Degrees, PlyReaderDegree,
                         testing::Values(DegreeCase{0, 0}, DegreeCase{9, 1}, DegreeCase{24, 2}, DegreeCase{45, 3},
                                         DegreeCase{72, 4}),
                         grtx::test::PrintedName{});

TEST(PlyReader, PermutedPropertiesGiveTheIdenticalScene) {
  const PlyTable table = sample_table(24, 300);  // more rows than one block of the reader
  const Scene expected = scene_from(binary_ply(table));
  std::vector<std::size_t> order(table.names.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::mt19937 random(7);
  for (int repeat = 0; repeat < 5; ++repeat) {
    std::shuffle(order.begin(), order.end(), random);
    PlyTable permuted;
    for (const std::size_t column : order) permuted.names.push_back(table.names[column]);
    for (const auto& row : table.rows) {
      std::vector<float> values;
      for (const std::size_t column : order) values.push_back(row[column]);
      permuted.rows.push_back(values);
    }
    expect_same_scene(scene_from(binary_ply(permuted)), expected);
  }
}

TEST(PlyReader, AsciiBigEndianAndCrLfGiveTheIdenticalScene) {
  const PlyTable table = sample_table(9, 20);
  const Scene expected = scene_from(binary_ply(table));

  Bytes big_endian;
  big_endian.text(ply_header("binary_big_endian", table));
  for (const auto& row : table.rows) {
    for (const float value : row) big_endian.add_swapped(value);
  }
  expect_same_scene(scene_from(big_endian.str()), expected);

  for (const std::string newline : {"\n", "\r\n"}) {
    std::string ascii = ply_header("ascii", table, newline);
    for (const auto& row : table.rows) {
      for (const float value : row) ascii += fmt::format(" {:.9g}\t", value);
      ascii += newline;
    }
    expect_same_scene(scene_from(ascii), expected);
    ascii.erase(ascii.size() - newline.size());  // the last newline may be missing
    expect_same_scene(scene_from(ascii), expected);
  }
  expect_same_scene(scene_from(binary_ply(table, "\r\n")), expected);
}

TEST(PlyReader, MissingNormalsAndExtraPropertiesChangeNothing) {
  const PlyTable table = sample_table(9, 5);
  const Scene expected = scene_from(binary_ply(table));
  Bytes bytes;
  bytes.text("ply\nformat binary_little_endian 1.0\nobj_info x\nelement vertex 5\nproperty uchar flag\n");
  for (std::size_t i = 0; i < table.names.size(); ++i) {
    if (i < 3 || i >= 6) bytes.text("property float32 " + table.names[i] + "\n");
    if (i == 8) bytes.text("property double confidence\n");
  }
  bytes.text("property int16 tail\nend_header\n");
  for (const auto& row : table.rows) {
    bytes.u8(7);
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (i < 3 || i >= 6) bytes.add(row[i]);
      if (i == 8) bytes.add(1e300);
    }
    bytes.add(std::int16_t{-3});
  }
  expect_same_scene(scene_from(bytes.str()), expected);
}

// Elements before and after the vertices, with lists, are stepped over; so are lists within the vertex element.
TEST(PlyReader, SkipsOtherElementsAndLists) {
  const PlyTable table = sample_table(0, 4);
  const Scene expected = scene_from(binary_ply(table));
  const std::string vertex_names = [&table] {
    std::string text;
    for (const std::string& name : table.names) text += "property float " + name + "\n";
    return text;
  }();
  const std::string declarations =
      "element face 2\nproperty list uchar int vertex_indices\nproperty uchar flag\nelement nothing 9\n"
      "element vertex 4\nproperty list ushort float weights\n" +
      vertex_names + "element camera 1\nproperty double f\n";

  Bytes binary;
  binary.text("ply\nformat binary_little_endian 1.0\n" + declarations + "end_header\n");
  binary.u8(3).add(std::int32_t{0}).add(std::int32_t{1}).add(std::int32_t{2}).u8(1);
  binary.u8(0).u8(2);
  std::string ascii = "ply\nformat ascii 1.0\n" + declarations + "end_header\n3 0 1 2 1\n0 2\n";
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    binary.add(static_cast<std::uint16_t>(i));
    ascii += std::to_string(i);
    for (std::size_t k = 0; k < i; ++k) {
      binary.f32(0.5);
      ascii += " 0.5";
    }
    for (const float value : table.rows[i]) {
      binary.add(value);
      ascii += fmt::format(" {:.9g}", value);
    }
    ascii += "\n";
  }
  binary.add(55.0);
  ascii += "55\n";
  expect_same_scene(scene_from(binary.str()), expected);
  expect_same_scene(scene_from(ascii), expected);
}

TEST(PlyReader, ReadsEveryScalarType) {
  const std::vector<std::string> types{"char",   "uchar", "short", "ushort", "int",    "uint",  "float",
                                       "double", "int8",  "uint8", "int16",  "uint16", "int32", "uint32"};
  const std::vector<std::string> names{"x",       "y",       "z",       "f_dc_0", "f_dc_1", "f_dc_2", "opacity",
                                       "scale_0", "scale_1", "scale_2", "rot_0",  "rot_1",  "rot_2",  "rot_3"};
  for (const bool big_endian : {false, true}) {
    Bytes bytes;
    bytes.text(big_endian ? "ply\nformat binary_big_endian 1.0\n" : "ply\nformat binary_little_endian 1.0\n");
    bytes.text("element vertex 1\n");
    for (std::size_t i = 0; i < names.size(); ++i) bytes.text("property " + types[i] + " " + names[i] + "\n");
    bytes.text("end_header\n");
    const auto add = [&](auto value) { big_endian ? bytes.add_swapped(value) : bytes.add(value); };
    add(std::int8_t{-100});
    add(std::uint8_t{200});
    add(std::int16_t{-30000});
    add(std::uint16_t{60000});
    add(std::int32_t{-70000});
    add(std::uint32_t{3000000000u});
    add(0.0f);
    add(0.0);
    add(std::int8_t{0});
    add(std::uint8_t{1});
    add(std::int16_t{0});
    add(std::uint16_t{2});
    add(std::int32_t{0});
    add(std::uint32_t{0});
    const Scene scene = scene_from(bytes.str());
    ASSERT_EQ(scene.size(), 1u);
    EXPECT_EQ(centre_of(scene, 0), glm::dvec3(-100.0, 200.0, -30000.0));
    EXPECT_EQ(scene.sh, (std::vector<float>{60000.0f, -70000.0f, 3000000000.0f}));
    EXPECT_FLOAT_EQ(scene.scale[0].z, 2.7182818f);
    EXPECT_EQ(scene.rotation[0].x, 1.0f);
  }
}

// Double positions far from the origin keep their differences.
TEST(PlyReader, KeepsDoublePositionsFarFromTheOrigin) {
  std::string ascii =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n";
  const std::vector<std::string> names = inria_names(0);
  for (std::size_t i = 6; i < names.size(); ++i) ascii += "property float " + names[i] + "\n";
  ascii += "end_header\n";
  for (const char* x : {"4500000.125", "4500000.25", "4500000.50"}) {
    ascii += std::string(x) + " 0 +1e1  0 0 0  0  0 0 0  1 0 0 0\n";
  }
  const Scene scene = scene_from(ascii);
  EXPECT_EQ(scene.offset, glm::dvec3(4500000.0, 0.0, 10.0));  // the median, rounded to float
  EXPECT_EQ(scene.mean[0].x, 0.125f);
  EXPECT_EQ(scene.mean[1].x, 0.25f);
  EXPECT_EQ(scene.mean[2].x, 0.5f);
}

TEST(PlyReader, EmptySceneWorks) {
  for (const char* format : {"ascii", "binary_little_endian"}) {
    const Scene scene = scene_from(ply_header(format, PlyTable{inria_names(0), {}}));
    EXPECT_EQ(scene.size(), 0u);
    EXPECT_EQ(scene.offset, glm::dvec3(0.0));
  }
}

TEST(PlyReader, CountsBytesBehindTheLastElement) {
  const Scene scene = scene_from(binary_ply(sample_table(0, 2)) + "abc");
  EXPECT_EQ(scene.size(), 2u);
  EXPECT_EQ(scene.report.noticed.at("bytes behind the last element"), 3u);
}

}  // namespace
}  // namespace grtx::frontend::test
