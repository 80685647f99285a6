// SPDX-License-Identifier: Apache-2.0
// Images survive their files: exactly in the float formats, rounded to bytes in PNG; bad files are refused by name.
#include "grtx/frontend/image/image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <limits>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "temporary_folder.h"

namespace grtx::frontend {
namespace {

using ::testing::HasSubstr;

class ImageFile : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_.path(name); }

  const grtx::test::TemporaryFolder folder_;
};

/// Values that a careless round trip changes: negative zero, denormals, huge, infinities, and rows that differ.
Image awkward_image() {
  Image image(5, 3);
  const float values[] = {0.0f,
                          -0.0f,
                          1.0f,
                          -1.5f,
                          3.4e38f,
                          1e-45f,
                          0.1f,
                          65504.5f,
                          1.0f / 3.0f,
                          std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()};
  std::size_t next = 0;
  for (glm::vec3& pixel : image.pixels) {
    for (int c = 0; c < 3; ++c) {
      pixel[c] = values[next % std::size(values)] + (next < std::size(values) ? 0.0f : static_cast<float>(next));
      ++next;
    }
  }
  return image;
}

TEST_F(ImageFile, FloatFormatsKeepEveryBit) {
  const Image image = awkward_image();
  for (const char* name : {"a.pfm", "a.exr", "UPPER.PFM"}) {
    SCOPED_TRACE(name);
    write_image(path(name), image);
    const Image back = read_image(path(name));
    ASSERT_EQ(back.width, image.width);
    ASSERT_EQ(back.height, image.height);
    EXPECT_EQ(std::memcmp(back.pixels.data(), image.pixels.data(), image.pixels.size() * sizeof(glm::vec3)), 0);
    EXPECT_TRUE(compare(image, back).identical());
  }
}

TEST_F(ImageFile, PfmIsLittleEndianWithTheBottomRowFirst) {
  Image image(1, 2);
  image.at(0, 0) = glm::vec3(1.0f, 2.0f, 3.0f);
  image.at(0, 1) = glm::vec3(4.0f, 5.0f, 6.0f);
  write_image(path("a.pfm"), image);
  const std::string bytes = read_file(path("a.pfm"));
  const std::string header = "PF\n1 2\n-1.0\n";
  ASSERT_EQ(bytes.size(), header.size() + 24);
  EXPECT_EQ(bytes.substr(0, header.size()), header);
  const char four[] = {'\x00', '\x00', '\x80', '\x40'};
  EXPECT_EQ(std::memcmp(bytes.data() + header.size(), four, 4), 0);
}

TEST_F(ImageFile, BigEndianAndGreyPfmAreRead) {
  write_file(path("big.pfm"), std::string("PF\n1 1\n1.0\n\x3f\x80\x00\x00\x40\x00\x00\x00\x40\x40\x00\x00", 23));
  EXPECT_EQ(read_image(path("big.pfm")).at(0, 0), glm::vec3(1.0f, 2.0f, 3.0f));
  write_file(path("grey.pfm"), std::string("Pf\n1 1\n-1.0\n\x00\x00\x80\x3f", 16));
  EXPECT_EQ(read_image(path("grey.pfm")).at(0, 0), glm::vec3(1.0f));
}

TEST_F(ImageFile, PngClampsAndRoundsHalfUp) {
  struct Case {
    float value;
    int byte;
  };
  const Case cases[] = {{0.0f, 0},
                        {1.0f, 255},
                        {-3.0f, 0},
                        {7.0f, 255},
                        {0.5f, 128},
                        {0.25f, 64},
                        {0.0019f, 0},
                        {0.00197f, 1},
                        {0.998f, 254},
                        {0.9981f, 255},
                        {std::numeric_limits<float>::quiet_NaN(), 0}};
  Image image(static_cast<unsigned>(std::size(cases)), 1);
  for (unsigned x = 0; x < image.width; ++x) image.at(x, 0) = glm::vec3(cases[x].value, 0.0f, 1.0f);
  write_image(path("a.png"), image);
  const Image back = read_image(path("a.png"));
  for (unsigned x = 0; x < image.width; ++x) {
    EXPECT_EQ(back.at(x, 0), glm::vec3(static_cast<float>(cases[x].byte) / 255.0f, 0.0f, 1.0f)) << cases[x].value;
  }
}

TEST_F(ImageFile, SameImageSameBytes) {
  for (const char* name : {"a.png", "a.exr", "a.pfm"}) {
    write_image(path(name), awkward_image());
    const std::string first = read_file(path(name));
    write_image(path(name), awkward_image());
    EXPECT_EQ(read_file(path(name)), first) << name;
  }
}

TEST_F(ImageFile, EveryTruncationIsRefusedByName) {
  for (const char* name : {"a.png", "a.exr", "a.pfm"}) {
    write_image(path(name), awkward_image());
    const std::string whole = read_file(path(name));
    for (std::size_t length = 0; length < whole.size(); length += 1 + whole.size() / 97) {
      write_file(path(name), whole.substr(0, length));
      try {
        read_image(path(name));
        ADD_FAILURE() << name << " cut to " << length << " of " << whole.size() << " bytes was accepted";
      } catch (const Error& error) {
        EXPECT_EQ(error.file(), path(name));
      }
    }
  }
}

TEST_F(ImageFile, ASmallExrThatClaimsGigabytesIsRefused) {
  write_image(path("a.exr"), awkward_image());
  const std::string whole = read_file(path("a.exr"));
  const auto with = [&](const std::string& attribute) {  // before all others
    write_file(path("a.exr"), whole.substr(0, 8) + attribute + whole.substr(8));
    try {
      read_image(path("a.exr"));
      return std::string("accepted");
    } catch (const Error& error) {
      return error.place() + ": " + error.rule();
    }
  };
  using namespace std::string_literals;
  const std::string refused = "byte 8: is no attribute that fits in the file";
  std::string several = whole;
  several[5] = '\x10';
  write_file(path("several.exr"), several);
  EXPECT_THROW(read_image(path("several.exr")), Error);
  EXPECT_NE(with("a\0string\0\3\0\0\0abc"s), refused);  // moves the pixels: OpenEXR refuses it
  EXPECT_EQ(with("a\0own\0\0\0\0\x64"s), refused);
  EXPECT_EQ(with("a\0string\0\0\0\0\x64"s), refused);
  EXPECT_EQ(with("a\0preview\0\x08\0\0\0\0\0\0\1\0\0\0\1"s), refused);
  EXPECT_EQ(with("a\0box2i\0\x0f\0\0\0"s + std::string(15, '\0')), refused);
  EXPECT_EQ(with("a\0chlist\0\4\0\0\0R\0\0\0"s), refused);
}

TEST_F(ImageFile, GarbageIsRefusedOrReadButNeverCrashes) {
  std::uint32_t state = 1;
  for (const char* name : {"a.png", "a.exr", "a.pfm"}) {
    write_image(path(name), awkward_image());
    const std::string whole = read_file(path(name));
    for (int round = 0; round < 200; ++round) {
      std::string damaged = whole;
      for (int flips = 0; flips < 3; ++flips) {
        state = state * 1664525u + 1013904223u;
        damaged[(state >> 8) % damaged.size()] = static_cast<char>(state >> 24);
      }
      write_file(path(name), damaged);
      try {
        const Image image = read_image(path(name));
        EXPECT_EQ(image.pixels.size(), std::size_t{image.width} * image.height);
      } catch (const Error& error) {
        EXPECT_EQ(error.file(), path(name));
      }
    }
    write_file(path(name), std::string(1000, 'x'));
    EXPECT_THROW(read_image(path(name)), Error);
  }
}

TEST_F(ImageFile, UnknownExtensionAndMissingFolderAreErrors) {
  for (const char* name : {"a.jpg", "png", "a.png.bak", "dir.png/a"}) {
    EXPECT_THAT([&] { write_image(path(name), Image(1, 1)); },
                ::testing::ThrowsMessage<Error>(::testing::HasSubstr(".png, .exr or .pfm")));
  }
  EXPECT_THROW(write_image(path("none/a.png"), Image(1, 1)), Error);
  EXPECT_THROW(read_image(path("none.png")), Error);
  EXPECT_THROW(write_image(path("empty.png"), Image()), Error);
}

TEST(ImageComparison, CountsPixelsAndMeasuresErrors) {
  Image a(2, 2);
  Image b(2, 2);
  EXPECT_TRUE(compare(a, b).identical());
  EXPECT_EQ(compare(a, b).psnr, std::numeric_limits<double>::infinity());
  b.at(1, 0).y = 0.5f;
  const Comparison one = compare(a, b);
  EXPECT_EQ(one.different_pixels, 1u);
  EXPECT_DOUBLE_EQ(one.max_error, 0.5);
  EXPECT_DOUBLE_EQ(one.mean_error, 0.5 / 12.0);
  EXPECT_NEAR(one.psnr, -10.0 * std::log10(0.25 / 12.0), 1e-12);
}

TEST(ImageComparison, PsnrSeesClampedValuesAndErrorsSeeRawOnes) {
  Image a(1, 1);
  Image b(1, 1);
  a.at(0, 0) = glm::vec3(2.0f);
  b.at(0, 0) = glm::vec3(3.0f);
  const Comparison result = compare(a, b);
  EXPECT_EQ(result.psnr, std::numeric_limits<double>::infinity());
  EXPECT_DOUBLE_EQ(result.max_error, 1.0);
  EXPECT_FALSE(result.identical());
}

TEST(ImageComparison, NotANumberIsAnInfiniteErrorUnlessBothHoldIt) {
  Image a(1, 1);
  a.at(0, 0).x = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(compare(a, a).identical());
  EXPECT_EQ(compare(a, Image(1, 1)).max_error, std::numeric_limits<double>::infinity());
}

TEST(ImageComparison, SizesMustMatch) {
  EXPECT_THAT([&] { compare(Image(2, 3), Image(3, 2)); },
              ::testing::ThrowsMessage<Error>(::testing::HasSubstr("2 x 3")));
}

}  // namespace
}  // namespace grtx::frontend
