// SPDX-License-Identifier: Apache-2.0
// Damaged .ply files end in one Error that names the place and the rule, never in a crash or a wrong scene.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "frontend/scene/ply_bytes.h"
#include "parameter_names.h"

namespace grtx::frontend::test {
namespace {

using testing::HasSubstr;

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), with);
}

struct DamageCase {
  const char* what;
  const char* replacement;
  const char* message;
  friend void PrintTo(const DamageCase& c, std::ostream* out) { *out << c.what << " -> " << c.replacement; }
};
class PlyDamage : public testing::TestWithParam<DamageCase> {};

TEST_P(PlyDamage, NamesPlaceAndRule) {
  const auto [what, replacement, message] = GetParam();
  EXPECT_THAT(scene_error(replaced(binary_ply(sample_table(9, 2)), what, replacement)), HasSubstr(message));
}

INSTANTIATE_TEST_SUITE_P(
    Header, PlyDamage,
    testing::Values(DamageCase{"ply\n", "plx\n", "byte 0"}, DamageCase{"ply\n", "ply \n", "line 1"},
                    DamageCase{"binary_little_endian 1.0", "binary_little_endian 2.0", "line 2"},
                    DamageCase{"binary_little_endian 1.0", "binary_middle_endian 1.0", "line 2: has an unknown format"},
                    DamageCase{"element vertex 2", "element vertex -2", "line 4"},
                    DamageCase{"element vertex 2", "element vertex 99999999999999999999", "line 4"},
                    DamageCase{"element vertex 2", "element vertex 18446744073709551615",
                               "row 2 of the 18446744073709551615 rows"},
                    DamageCase{"element vertex 2", "element vertex 3", "row 2 of the 3 rows"},
                    DamageCase{"element vertex 2", "element vertex", "line 4"},
                    DamageCase{"element vertex 2", "element face 2", "needs an element \"vertex\""},
                    DamageCase{"element vertex 2\n", "", "line 4: is a property before the first element"},
                    DamageCase{"property float x\n", "property float x\nproperty float x\n", "line 6"},
                    DamageCase{"property float x\n", "", "needs the property \"x\""},
                    DamageCase{"property float opacity\n", "", "needs the property \"opacity\""},
                    DamageCase{"property float scale_2\n", "", "2DGS"},
                    DamageCase{"property float rot_3\n", "", "\"rot_3\""},
                    DamageCase{"property float f_rest_4\n", "", "not 8"},
                    DamageCase{"property float f_rest_4\n", "property float f_rest_9\n", "\"f_rest_4\""},
                    DamageCase{"property float y\n", "property quaternion y\n", "line 6: has an unknown type"},
                    DamageCase{"property float y\n", "property list uchar float y\n", "must not be a list"},
                    DamageCase{"property float y\n", "property list float float y\n", "line 6"},
                    DamageCase{"property float y\n", "property float\n", "line 6"},
                    DamageCase{"comment made", "commend made", "line 3: has an unknown keyword"},
                    DamageCase{"format binary_little_endian 1.0\n", "", "format"},
                    DamageCase{"end_header\n", "end_heade\n", "line "}),
    grtx::test::NumberedName{});

TEST(PlyDamage, EveryTruncationIsAnError) {
  for (const unsigned f_rest : {0u, 9u}) {
    const std::string whole = binary_ply(sample_table(f_rest, 2));
    for (std::size_t length = 0; length < whole.size(); ++length) {
      EXPECT_THROW(scene_from(std::string_view(whole).substr(0, length)), Error) << length;
    }
  }
}

TEST(PlyDamage, EveryTruncationOfAnAsciiFileIsAnErrorUpToItsLastNumber) {
  std::string whole = ply_header("ascii", sample_table(0, 2));
  const std::size_t row = 17 * 2;
  for (int i = 0; i < 2; ++i) whole += "1 2 3 0 0 1 0 0 0 0 0 0 0 1 0 0 0\n";
  ASSERT_EQ(scene_from(whole).size(), 2u);
  for (std::size_t length = 0; length + 1 < whole.size(); ++length) {
    EXPECT_THROW(scene_from(std::string_view(whole).substr(0, length)), Error) << length << " of row " << row;
  }
}

TEST(PlyDamage, AsciiErrorsNameTheLine) {
  const PlyTable table = sample_table(0, 2);
  const std::string head = ply_header("ascii", table);  // 4 lines, 17 properties, end_header: data from line 23 on
  const std::string good = "1 2 3 0 0 1 0 0 0 0 0 0 0 1 0 0 0\n";
  EXPECT_THAT(scene_error(head + good + "1 2 3 0 0 1 0 0 0 0 0 0 0 1 0 0\n"), HasSubstr("line 24: has no value"));
  EXPECT_THAT(scene_error(head + good + "1 2 3 0 0 1 0 0 0 0 0 0 0 1 0 0 0 9\n"), HasSubstr("line 24: has more"));
  EXPECT_THAT(scene_error(head + "1 two 3 0 0 1 0 0 0 0 0 0 0 1 0 0 0\n" + good), HasSubstr("line 23: has a value"));
  EXPECT_THAT(scene_error(replaced(head, "property float x", "property uchar x") +
                          "256 2 3 0 0 1 0 0 0 0 0 0 0 1 0 0 0\n" + good),
              HasSubstr("line 23: has a value outside the type"));
}

TEST(PlyDamage, ListsThatRunBeyondTheFileAreErrors) {
  const std::string head =
      "ply\nformat binary_little_endian 1.0\nelement face 1\nproperty list int float weights\nelement vertex 0\n";
  std::string names;
  for (const std::string& name : inria_names(0)) names += "property float " + name + "\n";
  for (const std::int32_t length : {-1, 1, 2147483647}) {
    Bytes bytes;
    bytes.text(head + names + "end_header\n").add(length);
    EXPECT_THAT(scene_error(bytes.str()), HasSubstr("the file ends in row 0 of the 1 rows of element \"face\""));
  }
}

TEST(PlyDamage, RandomChangesNeverCrash) {
  std::mt19937 random(11);
  const std::string whole = binary_ply(sample_table(9, 3));
  int loaded = 0, refused = 0;
  for (int repeat = 0; repeat < 1500; ++repeat) {
    std::string damaged = whole;
    const unsigned changes = 1 + random() % 4;
    for (unsigned change = 0; change < changes; ++change)
      damaged[random() % damaged.size()] = static_cast<char>(random() % 256);
    try {
      const Scene scene = scene_from(damaged);
      EXPECT_EQ(scene.mean.size(), scene.opacity.size());
      ++loaded;
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(loaded, 0);  // both outcomes happen, so the changes do reach header and data
  EXPECT_GT(refused, 0);
}

TEST(PlyDamage, RandomBytesAreNoScene) {
  std::mt19937 random(13);
  for (int repeat = 0; repeat < 300; ++repeat) {
    std::string garbage = repeat % 3 == 0 ? "ply\n" : repeat % 3 == 1 ? "" : "NGSP";
    const std::size_t length = (repeat % 3 == 1 ? 32 * 16 : random() % 400);
    while (garbage.size() < length) garbage += static_cast<char>(random() % 256);
    EXPECT_THROW(scene_from(garbage), Error) << repeat;
  }
}

TEST(PlyDamage, MissingAndEmptyFilesAreErrors) {
  EXPECT_THROW(load_scene("no/such/file.ply"), Error);
  EXPECT_THROW(load_scene(testing::TempDir()), Error);
  EXPECT_THAT(scene_error(""), HasSubstr("is empty"));
  EXPECT_THAT(
      scene_error("This is a letter, not a scene; it even has a multiple of 32 bytes. Best wishes from all of us..."),
      HasSubstr("none of them"));
}

}  // namespace
}  // namespace grtx::frontend::test
