// SPDX-License-Identifier: Apache-2.0
// .ksplat: files of its own library (tests/data/converters) and damage to them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "frontend/scene/scene_bytes.h"
#include "paths.h"

namespace grtx::frontend::test {
namespace {

using testing::HasSubstr;

std::string fixture(const std::string& name) {
  return read_file(grtx::paths::source_dir() + "/tests/data/converters/" + name);
}

template <typename T>
std::string with(std::string bytes, std::size_t at, T value) {
  std::memcpy(&bytes[at], &value, sizeof value);
  return bytes;
}

constexpr std::size_t kSection = 4096;  // header of the first section

TEST(KsplatReader, DecodesARowWrittenByHand) {
  Bytes bytes;
  bytes.u8(0).u8(1).u8(0).u8(0);
  for (const std::uint32_t count : {1U, 1U, 1U, 1U, 0U}) bytes.add(count);  // sections, splats, level 0
  std::string header = bytes.str() + std::string(4096 - bytes.size(), '\0');
  Bytes section;
  for (const std::uint32_t count : {1U, 1U}) section.add(count);
  header += section.str() + std::string(1024 - section.size(), '\0');
  Bytes row;
  for (const double number : {1.0, 2.0, 3.0, 0.5, 0.25, 4.0, 0.0, 0.0, 1.0, 0.0}) row.f32(number);
  row.u8(0).u8(128).u8(255).u8(51);
  const Scene scene = scene_from(header + row.str());
  ASSERT_EQ(scene.size(), 1U);
  EXPECT_EQ(centre_of(scene, 0), glm::dvec3(1.0, 2.0, 3.0));
  EXPECT_FLOAT_EQ(scene.scale[0].y, 0.25F);
  EXPECT_EQ(scene.rotation[0], glm::quat(0.0F, 0.0F, 1.0F, 0.0F));
  EXPECT_FLOAT_EQ(scene.opacity[0], 0.2F);
  EXPECT_NEAR(0.5 + 0.28209479177387814 * static_cast<double>(scene.sh[1]), 128.0 / 255.0, 1e-6);
}

TEST(KsplatReader, RefusesDamageInOneLine) {
  const std::string good = fixture("d3.l2.ksplat");
  EXPECT_EQ(scene_error(with(good, 20, std::uint16_t{3})), "byte 20: the level of compression must be 0 to 2, not 3");
  EXPECT_THAT(scene_error(with(good, 4, std::uint32_t{99})), HasSubstr("byte 4: names 99 sections"));
  EXPECT_THAT(scene_error(with(good, 16, std::uint32_t{119})),
              HasSubstr("byte 16: names 119 splats, the sections hold 120"));
  EXPECT_THAT(scene_error(with(good, kSection, std::uint32_t{7})), HasSubstr("section 0: holds 7 of 120 splats"));
  EXPECT_THAT(scene_error(with(good, kSection + 40, std::uint16_t{3})),
              HasSubstr("section 0: the SH degree must be 0 to 2"));
  EXPECT_THAT(scene_error(with(good, kSection + 20, std::uint16_t{8})),
              HasSubstr("a bucket must have 12 bytes, not 8"));
  EXPECT_THAT(scene_error(with(good, kSection + 8, std::uint32_t{999})), HasSubstr("hold more splats than it has"));
  EXPECT_THAT(scene_error(with(good, kSection + 32, std::uint32_t{0})), HasSubstr("splats than it has"));
  for (std::size_t length = 4096; length < good.size(); length += 7) EXPECT_NE(scene_error(good.substr(0, length)), "");
}

TEST(KsplatReader, BytesBehindTheLastSectionAreNoticed) {
  EXPECT_EQ(scene_from(fixture("d3.l0.ksplat") + "xyz").report.noticed.at("bytes behind the last element"), 3U);
}

}  // namespace
}  // namespace grtx::frontend::test
