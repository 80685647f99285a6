// SPDX-License-Identifier: Apache-2.0
// PlayCanvas compressed .ply, packed by hand from the format's bit layout.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "frontend/scene/scene_bytes.h"
#include "parameter_names.h"

namespace grtx::frontend::test {
namespace {

using testing::HasSubstr;

constexpr const char* kLimits[] = {
    "min_x",       "min_y",       "min_z",       "max_x", "max_y", "max_z", "min_scale_x", "min_scale_y", "min_scale_z",
    "max_scale_x", "max_scale_y", "max_scale_z", "min_r", "min_g", "min_b", "max_r",       "max_g",       "max_b"};

std::string header(std::size_t chunks, std::size_t limits, std::size_t vertices, std::size_t sh_rows, unsigned f_rest) {
  std::string text = "ply\nformat binary_little_endian 1.0\nelement chunk " + std::to_string(chunks) + "\n";
  for (std::size_t i = 0; i < limits; ++i) text += std::string("property float ") + kLimits[i] + "\n";
  text += "element vertex " + std::to_string(vertices) + "\n";
  for (const char* name : {"position", "rotation", "scale", "color"})
    text += std::string("property uint packed_") + name + "\n";
  if (f_rest > 0) {
    text += "element sh " + std::to_string(sh_rows) + "\n";
    for (unsigned i = 0; i < f_rest; ++i) text += "property uchar f_rest_" + std::to_string(i) + "\n";
  }
  return text + "end_header\n";
}

Bytes& add_chunk(Bytes& bytes, std::size_t limits, double shift = 0.0) {
  const double values[] = {-1 + shift, -2, -3, 1 + shift, 2, 3, -4, -5, -6, 0, 1, 2, -0.5, 0, 0.5, 0.5, 1, 1.5};
  for (std::size_t i = 0; i < limits; ++i) bytes.f32(values[i]);
  return bytes;
}

std::uint32_t pack_11_10_11(unsigned x, unsigned y, unsigned z) { return x << 21 | y << 11 | z; }

TEST(CompressedPlyReader, DecodesOneGaussianWrittenByHand) {
  for (const std::size_t limits : {std::size_t{12}, std::size_t{18}}) {
    Bytes bytes;
    bytes.text(header(1, limits, 1, 1, 9));
    add_chunk(bytes, limits);
    bytes.add(pack_11_10_11(0, 1023, 1000));                               // -1, 2, -3 + 6 * 1000 / 2047
    bytes.add(std::uint32_t{2u << 30 | 1023u << 20 | 300u << 10 | 511u});  // y omitted; w, x, z follow
    bytes.add(pack_11_10_11(2047, 0, 512));                                // log scale 0, -5, -6 + 8 * 512 / 2047
    bytes.add(std::uint32_t{0u << 24 | 51u << 16 | 255u << 8 | 102u});     // r 0, g 0.2, b 1, opacity 0.4
    for (const unsigned byte : {0u, 255u, 127u, 128u, 1u, 254u, 64u, 192u, 100u}) bytes.u8(byte);
    const Scene scene = scene_from(bytes.str());
    ASSERT_EQ(scene.size(), 1u);
    ASSERT_EQ(scene.sh_degree, 1u);
    EXPECT_NEAR(centre_of(scene, 0).x, -1.0, 1e-6);
    EXPECT_NEAR(centre_of(scene, 0).y, 2.0, 1e-6);
    EXPECT_NEAR(centre_of(scene, 0).z, -3.0 + 6.0 * 1000.0 / 2047.0, 1e-6);
    EXPECT_FLOAT_EQ(scene.scale[0].x, 1.0f);
    EXPECT_FLOAT_EQ(scene.scale[0].y, static_cast<float>(std::exp(-5.0)));
    EXPECT_NEAR(scene.scale[0].z, std::exp(-6.0 + 8.0 * 512.0 / 2047.0), 1e-6);
    // w = sqrt(1/2); x, z from their bits; y is what is missing to norm 1
    const double w = std::sqrt(0.5), x = (300.0 / 1023.0 - 0.5) * std::sqrt(2.0),
                 z = (511.0 / 1023.0 - 0.5) * std::sqrt(2.0);
    EXPECT_NEAR(scene.rotation[0].w, w, 1e-6);
    EXPECT_NEAR(scene.rotation[0].x, x, 1e-6);
    EXPECT_NEAR(scene.rotation[0].y, std::sqrt(1.0 - w * w - x * x - z * z), 1e-6);
    EXPECT_NEAR(scene.rotation[0].z, z, 1e-6);
    EXPECT_NEAR(scene.opacity[0], 0.4f, 1e-6f);
    const double c0 = 0.28209479177387814;
    const bool coloured = limits == 18;  // lerp between the chunk's limits
    EXPECT_NEAR(0.5 + c0 * scene.sh[0], coloured ? -0.5 : 0.0, 1e-6);
    EXPECT_NEAR(0.5 + c0 * scene.sh[1], 0.2, 1e-6);
    EXPECT_NEAR(0.5 + c0 * scene.sh[2], coloured ? 1.5 : 1.0, 1e-6);
    // channel-major bytes; 0 and 255 are the exact ends -4 and 4
    EXPECT_FLOAT_EQ(scene.sh[3], -4.0f);
    EXPECT_FLOAT_EQ(scene.sh[6], 4.0f);
    EXPECT_FLOAT_EQ(scene.sh[9], (127.5f / 256.0f - 0.5f) * 8.0f);
    EXPECT_FLOAT_EQ(scene.sh[4], (128.5f / 256.0f - 0.5f) * 8.0f);
    EXPECT_FLOAT_EQ(scene.sh[7], (1.5f / 256.0f - 0.5f) * 8.0f);
    EXPECT_FLOAT_EQ(scene.sh[11], (100.5f / 256.0f - 0.5f) * 8.0f);
  }
}

TEST(CompressedPlyReader, TakesTheLimitsOfEachRowsChunk) {
  constexpr std::size_t kRows = 513;
  Bytes bytes;
  bytes.text(header(3, 12, kRows, 0, 0));
  for (int chunk = 0; chunk < 3; ++chunk) add_chunk(bytes, 12, 100.0 * chunk);
  for (std::size_t i = 0; i < kRows; ++i) {
    bytes.add(pack_11_10_11(0, 0, 0)).add(std::uint32_t{512u << 20 | 512u << 10 | 512u});
    bytes.add(pack_11_10_11(0, 0, 0)).add(std::uint32_t{128});
  }
  const Scene scene = scene_from(bytes.str());
  ASSERT_EQ(scene.size(), kRows);
  EXPECT_EQ(centre_of(scene, 255).x, -1.0);
  EXPECT_EQ(centre_of(scene, 256).x, 99.0);
  EXPECT_EQ(centre_of(scene, 511).x, 99.0);
  EXPECT_EQ(centre_of(scene, 512).x, 199.0);
}

TEST(CompressedPlyReader, EmptySceneWorks) {
  EXPECT_EQ(scene_from(header(0, 18, 0, 0, 9)).size(), 0u);
  EXPECT_EQ(scene_from(header(0, 12, 0, 0, 0)).size(), 0u);
}

std::string small_file() {
  Bytes bytes;
  bytes.text(header(1, 18, 2, 2, 9));
  add_chunk(bytes, 18);
  for (int i = 0; i < 2; ++i) {
    bytes.add(std::uint32_t{123456789})
        .add(std::uint32_t{3123456789})
        .add(std::uint32_t{323456789})
        .add(std::uint32_t{77777777});
  }
  for (unsigned i = 0; i < 18; ++i) bytes.u8(i * 13);
  return bytes.str();
}

TEST(CompressedPlyReader, EveryTruncationIsAnError) {
  const std::string whole = small_file();
  ASSERT_EQ(scene_from(whole).size(), 2u);
  for (std::size_t length = 0; length < whole.size(); ++length) {
    EXPECT_THROW(scene_from(std::string_view(whole).substr(0, length)), Error) << length;
  }
}

struct DamageCase {
  const char* what;
  const char* replacement;
  const char* message;
  friend void PrintTo(const DamageCase& c, std::ostream* out) { *out << c.what << " -> " << c.replacement; }
};
class CompressedPlyDamage : public testing::TestWithParam<DamageCase> {};

TEST_P(CompressedPlyDamage, NamesPlaceAndRule) {
  std::string bytes = small_file();
  const std::size_t at = bytes.find(GetParam().what);
  ASSERT_NE(at, std::string::npos);
  bytes.replace(at, std::strlen(GetParam().what), GetParam().replacement);
  EXPECT_THAT(scene_error(bytes + std::string(100, '\0')), HasSubstr(GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(Header, CompressedPlyDamage,
                         testing::Values(DamageCase{"element chunk 1", "element chunk 2", "must have 1 rows, not 2"},
                                         DamageCase{"element chunk 1", "element chunk 0", "must have 1 rows, not 0"},
                                         DamageCase{"element sh 2", "element sh 1", "must have 2 rows, not 1"},
                                         DamageCase{"property uchar f_rest_8\n", "", "not 8"},
                                         DamageCase{"property float max_scale_z\n", "", "\"max_scale_z\""},
                                         DamageCase{"property float max_g\n", "", "\"max_g\""},
                                         DamageCase{"uint packed_scale", "float packed_scale",
                                                    "must be of an integer type"},
                                         DamageCase{"uint packed_color", "uint packed_colour", "\"packed_color\""},
                                         DamageCase{"uchar f_rest_3", "float f_rest_3", "must be of an integer type"}),
                         grtx::test::NumberedName{});

}  // namespace
}  // namespace grtx::frontend::test
