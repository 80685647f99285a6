// SPDX-License-Identifier: Apache-2.0
// .spz versions 1 to 4, built from the format's description without its library.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zstd.h>

#include <cmath>
#include <random>

#include "error_of.h"
#include "frontend/scene/scene_bytes.h"
#include "grtx/frontend/scene/decompress.h"
#include "grtx/frontend/scene/readers.h"
#include "limited_memory.h"

namespace grtx::frontend::test {
namespace {

using testing::HasSubstr;

// A gzip stream of stored (uncompressed) deflate blocks.
std::string gzip(const std::string& plain) {
  Bytes bytes;
  bytes.text("\x1f\x8b\x08").u8(0).add(std::uint32_t{0}).u8(0).u8(255);
  std::size_t at = 0;
  do {
    const std::size_t length = std::min<std::size_t>(plain.size() - at, 65535);
    bytes.u8(at + length == plain.size())
        .add(static_cast<std::uint16_t>(length))
        .add(static_cast<std::uint16_t>(~length));
    bytes.text(std::string_view(plain).substr(at, length));
    at += length;
  } while (at < plain.size());
  std::uint32_t crc = 0xffffffffu;
  for (const char c : plain) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1u) != 0 ? 0xedb88320u : 0u);
  }
  bytes.add(~crc).add(static_cast<std::uint32_t>(plain.size()));
  return bytes.str();
}

std::string zstd(const std::string& plain) {
  std::string packed(ZSTD_compressBound(plain.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), plain.data(), plain.size(), 3));
  return packed;
}

struct Attributes {
  std::string positions, alphas, colours, scales, rotations, harmonics;
};

std::string gzip_file(unsigned version, unsigned points, unsigned degree, const Attributes& a, unsigned flags = 0) {
  Bytes bytes;
  bytes.text("NGSP").add(std::uint32_t{version}).add(std::uint32_t{points}).u8(degree).u8(12).u8(flags).u8(0);
  bytes.text(a.positions).text(a.alphas).text(a.colours).text(a.scales).text(a.rotations).text(a.harmonics);
  return gzip(bytes.str());
}

std::string zstd_file(unsigned points, unsigned degree, const Attributes& a, unsigned flags = 0) {
  std::vector<std::string> streams{a.positions, a.alphas, a.colours, a.scales, a.rotations};
  if (degree > 0) streams.push_back(a.harmonics);
  Bytes bytes;
  bytes.text("NGSP").add(std::uint32_t{4}).add(std::uint32_t{points}).u8(degree).u8(12).u8(flags);
  bytes.u8(static_cast<unsigned>(streams.size())).add(std::uint32_t{32});
  for (int i = 0; i < 12; ++i) bytes.u8(0);
  std::string data;
  for (const std::string& stream : streams) {
    const std::string packed = zstd(stream);
    bytes.add(std::uint64_t{packed.size()}).add(std::uint64_t{stream.size()});
    data += packed;
  }
  return bytes.text(data).str();
}

Bytes& add_i24(Bytes& bytes, std::int32_t value) {
  const auto bits = static_cast<std::uint32_t>(value);
  return bytes.u8(bits & 255).u8((bits >> 8) & 255).u8((bits >> 16) & 255);
}

std::string fixed_positions() {  // step 1/4096: (1, 2, -3) and (0.5, -0.25, 2047)
  Bytes bytes;
  for (const int value : {4096, 8192, -12288, 2048, -1024, 2047 * 4096}) add_i24(bytes, value);
  return bytes.str();
}

std::string sequence(std::size_t count, unsigned first, unsigned step) {
  Bytes bytes;
  for (std::size_t i = 0; i < count; ++i) bytes.u8((first + static_cast<unsigned>(i) * step) % 256);
  return bytes.str();
}

// Two points. Rotations of versions 3 and 4: largest w, x y z = +a -b 0; largest x, y z w = 0 0 c.
std::string smallest_three() {
  Bytes bytes;
  const std::uint32_t a = 256, b = 512 | 128, c = 511;
  bytes.add(std::uint32_t{3u << 30 | a << 20 | b << 10}).add(std::uint32_t{0u << 30 | c});
  return bytes.str();
}

Attributes two_points(unsigned version, unsigned degree) {
  Attributes a;
  a.positions = fixed_positions();
  a.alphas = sequence(2, 51, 51);   // opacity 0.2, 0.4
  a.colours = sequence(6, 0, 51);   // 0, 0.2 .. 1
  a.scales = sequence(6, 144, 16);  // log scale -1, 0, 1 ... 4
  a.rotations = version <= 2 ? Bytes().u8(255).u8(0).u8(0).u8(0).u8(255).u8(255).str() : smallest_three();
  a.harmonics = sequence(2 * 3 * ((degree + 1) * (degree + 1) - 1), 1, 1);
  return a;
}

void expect_common_attributes(const Scene& scene, double flip) {
  ASSERT_EQ(scene.size(), 2u);
  EXPECT_EQ(centre_of(scene, 0), glm::dvec3(1.0, flip * 2.0, flip * -3.0));
  EXPECT_EQ(centre_of(scene, 1), glm::dvec3(0.5, flip * -0.25, flip * 2047.0));
  EXPECT_NEAR(scene.opacity[0], 0.2f, 1e-6f);
  EXPECT_NEAR(scene.opacity[1], 0.4f, 1e-6f);
  for (int c = 0; c < 3; ++c) EXPECT_FLOAT_EQ(scene.scale[0][c], static_cast<float>(std::exp(c - 1)));
  const std::size_t stride = scene.sh_coefficients() * 3;
  for (unsigned c = 0; c < 3; ++c) {
    EXPECT_NEAR(scene.sh[c], (0.2 * c - 0.5) / 0.15, 1e-6);
    EXPECT_NEAR(scene.sh[stride + c], (0.2 * (c + 3) - 0.5) / 0.15, 1e-6);
  }
}

void expect_quaternion(const glm::quat& q, double w, double x, double y, double z) {
  EXPECT_NEAR(q.w, w, 1e-6);
  EXPECT_NEAR(q.x, x, 1e-6);
  EXPECT_NEAR(q.y, y, 1e-6);
  EXPECT_NEAR(q.z, z, 1e-6);
}

TEST(SpzReader, Version2BytesOfTheRotation) {
  Attributes a = two_points(2, 0);
  a.rotations = Bytes().u8(255).u8(127).u8(128).u8(0).u8(127).u8(127).str();
  const Scene scene = scene_from(gzip_file(2, 2, 0, a), {.spz_raw_axes = true});
  expect_common_attributes(scene, 1.0);
  const double small = 0.5 / 127.5, norm = std::sqrt(1.0 + 2.0 * small * small);  // w = sqrt(max(0, 1 - ...)) = 0
  expect_quaternion(scene.rotation[0], 0.0, 1.0 / norm, -small / norm, small / norm);
  expect_quaternion(scene.rotation[1], 0.0, -1.0 / norm, -small / norm, -small / norm);
}

TEST(SpzReader, Version1HasHalfFloatPositions) {
  Attributes a = two_points(1, 0);
  Bytes halves;  // 1, -2, 65504, 2^-24, 0.5, infinity
  for (const unsigned bits : {0x3c00u, 0xc000u, 0x7bffu, 0x0001u, 0x3800u, 0x7c00u})
    halves.add(static_cast<std::uint16_t>(bits));
  a.positions = halves.str();
  const Scene scene = scene_from(gzip_file(1, 2, 0, a), {.spz_raw_axes = true});
  ASSERT_EQ(scene.size(), 1u);  // the point at infinity is dropped
  EXPECT_EQ(centre_of(scene, 0), glm::dvec3(1.0, -2.0, 65504.0));
  EXPECT_EQ(scene.report.dropped.at("non-finite position"), 1u);
}

TEST(SpzReader, Versions3And4GiveTheSameScene) {
  for (unsigned degree = 0; degree <= 4; ++degree) {
    const Attributes a = two_points(3, degree);
    const Scene v3 = scene_from(gzip_file(3, 2, degree, a)), v4 = scene_from(zstd_file(2, degree, a));
    EXPECT_EQ(v3.sh_degree, degree);
    expect_same_scene(v3, v4);
    expect_common_attributes(v4, -1.0);
  }
}

TEST(SpzReader, SmallestThreeRotation) {
  const Scene raw = scene_from(zstd_file(2, 0, two_points(4, 0)), {.spz_raw_axes = true});
  const double x = 256.0 / 511.0 * std::sqrt(0.5), y = -128.0 / 511.0 * std::sqrt(0.5);
  expect_quaternion(raw.rotation[0], std::sqrt(1.0 - x * x - y * y), x, y, 0.0);
  expect_quaternion(raw.rotation[1], std::sqrt(0.5), std::sqrt(0.5), 0.0, 0.0);
  const Scene turned = scene_from(zstd_file(2, 0, two_points(4, 0)));  // (w, x, -y, -z)
  expect_quaternion(turned.rotation[0], std::sqrt(1.0 - x * x - y * y), x, -y, 0.0);
  EXPECT_NE(raw.hash, turned.hash);
}

// Three stored components of largest magnitude leave a negative number under the root.
TEST(SpzReader, OverfullRotationIsNoNan) {
  Attributes a = two_points(3, 0);
  a.rotations = Bytes().add(std::uint32_t{3u << 30 | 511u << 20 | 511u << 10 | 511u}).add(std::uint32_t{0}).str();
  const Scene scene = scene_from(gzip_file(3, 2, 0, a), {.spz_raw_axes = true});
  ASSERT_EQ(scene.size(), 2u);
  expect_quaternion(scene.rotation[0], 0.0, std::sqrt(1.0 / 3), std::sqrt(1.0 / 3), std::sqrt(1.0 / 3));
}

// The bases of degrees 1 to 3 are polynomials in x, y, z; a coefficient changes sign when y and z together have an odd
// power in its basis (section "Spherical harmonics" of the 3DGS papers: order -y z -x, xy yz 2zz-xx-yy xz xx-yy, ...).
TEST(SpzReader, AxesChangeTheSignOfOddCoefficients) {
  const std::vector<const char*> odd_part{"y", "z",   "x",   "xy", "yz",  "zz",  "xz", "xx",
                                          "y", "xyz", "yzz", "z",  "xzz", "zxx", "x"};
  const Attributes a = two_points(3, 3);
  const Scene raw = scene_from(gzip_file(3, 2, 3, a), {.spz_raw_axes = true}),
              turned = scene_from(gzip_file(3, 2, 3, a));
  for (std::size_t i = 0; i < raw.sh.size(); ++i) {
    const std::size_t j = i / 3 % 16;
    double sign = 1.0;
    if (j > 0) {
      for (const char* p = odd_part[j - 1]; *p != '\0'; ++p) sign *= *p == 'x' ? 1.0 : -1.0;
      const std::size_t byte = (i / 48 * 45 + (j - 1) * 3 + i % 3 + 1) % 256;
      EXPECT_EQ(raw.sh[i], (static_cast<float>(byte) - 128.0f) / 128.0f);
    }
    EXPECT_EQ(turned.sh[i], static_cast<float>(sign) * raw.sh[i]) << "coefficient " << j;
  }
}

TEST(SpzReader, EmptyScenesOfAllVersions) {
  EXPECT_EQ(scene_from(gzip_file(3, 0, 3, {})).size(), 0u);
  Bytes bytes;
  bytes.text("NGSP").add(std::uint32_t{4}).add(std::uint32_t{0}).u8(0).u8(12).u8(0).u8(0).add(std::uint32_t{32});
  for (int i = 0; i < 12; ++i) bytes.u8(0);
  EXPECT_EQ(scene_from(bytes.str()).size(), 0u);
}

TEST(SpzReader, NoticesAntialiasingAndRefusesExtensions) {
  const Attributes a = two_points(3, 0);
  EXPECT_EQ(
      scene_from(gzip_file(3, 2, 0, a, 1)).report.noticed.count("trained with an anti-aliasing filter (header flag)"),
      1u);
  EXPECT_THAT(scene_error(gzip_file(3, 2, 0, a, 2)), HasSubstr("extensions"));
  EXPECT_THAT(scene_error(zstd_file(2, 0, a, 3)), HasSubstr("extensions"));
}

TEST(SpzReader, EveryTruncationIsAnError) {
  for (const std::string& whole : {gzip_file(2, 2, 1, two_points(2, 1)), zstd_file(2, 1, two_points(4, 1))}) {
    for (std::size_t length = 0; length < whole.size(); ++length) {
      EXPECT_THROW(scene_from(std::string_view(whole).substr(0, length)), Error) << length;
    }
    EXPECT_THROW(scene_from(whole + "x"), Error);
  }
}

TEST(SpzReader, WrongHeadersAreErrors) {
  const Attributes a = two_points(3, 0);
  EXPECT_THAT(scene_error(gzip("not a scene but a gzip file all the same")), HasSubstr("no .spz"));
  EXPECT_THAT(scene_error(gzip_file(4, 2, 0, a)), HasSubstr("version 1, 2 or 3, not 4"));
  EXPECT_THAT(scene_error(gzip_file(3, 3, 0, a)), HasSubstr("3 points of SH degree 0 must end at byte"));
  EXPECT_THAT(scene_error(gzip_file(3, 4294967295u, 4, a)), HasSubstr("must end at byte"));
  EXPECT_THAT(scene_error(gzip_file(3, 2, 5, a)), HasSubstr("SH degree"));
  EXPECT_THAT(scene_error(zstd_file(4000000000u, 0, a)), HasSubstr("plain size"));
  std::string wrong_version = zstd_file(2, 0, a);
  wrong_version[4] = 9;
  EXPECT_THAT(scene_error(wrong_version), HasSubstr("byte 4: a plain .spz must be of version 4, not 9"));
  std::string damaged = gzip_file(3, 2, 0, a);
  damaged[40] = static_cast<char>(damaged[40] + 1);  // the checksum finds it
  EXPECT_THAT(scene_error(damaged), HasSubstr("gzip stream is damaged"));
}

TEST(SpzReader, RandomChangesNeverCrash) {
  std::mt19937 random(17);
  const std::string whole = zstd_file(2, 2, two_points(4, 2));
  int refused = 0;
  for (int repeat = 0; repeat < 800; ++repeat) {
    std::string damaged = whole;
    damaged[random() % damaged.size()] = static_cast<char>(random() % 256);
    try {
      EXPECT_LE(scene_from(damaged).size(), 2u);
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 100);
}

// Sizes around the inflater's step of 1 MiB.
TEST(Decompress, SizesAroundTheStep) {
  constexpr std::size_t kStep = std::size_t{1} << 20;
  for (const std::size_t size : {kStep - 1, kStep, kStep + 1, 2 * kStep}) {
    std::string plain(size, 'a');
    for (std::size_t i = 0; i < size; i += 7) plain[i] = static_cast<char>(i * 31 % 251);
    EXPECT_TRUE(inflate_zstd(zstd(plain), size, 0, "f") == plain) << size;
    EXPECT_THROW(inflate_zstd(zstd(plain), size - 1, 0, "f"), Error);
    EXPECT_THROW(inflate_zstd(zstd(plain), size + 1, 0, "f"), Error);
    EXPECT_TRUE(inflate_gzip(gzip(plain), size + 1, "f") == plain) << size;
  }
}

// The header counts the points: what comes out beyond them is never asked for.
TEST(SpzReader, ASmallFileIsInflatedNoFurtherThanItsHeaderSays) {
  std::string head(16, '\0');
  head.replace(0, 4, "NGSP");
  head[4] = 3;
  head[8] = 10;
  const std::string bomb = gzip(head + std::string(std::size_t{64} << 20, '\0'));
  EXPECT_EQ(inflate_gzip(bomb, 1000, "f").size(), 1000U);
  const grtx::test::LimitedMemory limit(std::uint64_t{32} << 20);
  EXPECT_EQ(grtx::test::error_of([&] { read_spz(bomb, false, "f"); }),
            "f: inflated byte 216: 10 points of SH degree 0 must end at byte 216");
}

TEST(SpzReader, ACountThatIsHonestIsRefusedWithItsSizeWhereThereIsNoMemory) {
  std::string file(16, '\0');
  file.replace(0, 4, "NGSP");
  file[4] = 3;
  file[10] = 0x10;  // 1,048,576 points of 20 bytes
  file = gzip(file + std::string((std::size_t{20} << 20), '\0'));
  const grtx::test::LimitedMemory limit(std::uint64_t{64} << 20);
  EXPECT_THAT(grtx::test::error_of([&] { read_spz(file, false, "f"); }),
              testing::MatchesRegex("f: 1048576 Gaussians: takes .* MB more memory, and .* MB are free"));
}

}  // namespace
}  // namespace grtx::frontend::test
