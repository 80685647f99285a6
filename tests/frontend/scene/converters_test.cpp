// SPDX-License-Identifier: Apache-2.0
// Our readers on bytes that programs of others wrote from a generated scene (tests/data/converters/README.md), compared
// with that scene within each format's quantisation. With GRTX_SPLAT_TRANSFORM (path of the npm program
// splat-transform) larger scenes make the round trip, and its reader checks ours.
#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>

#include "frontend/scene/scene_bytes.h"
#include "frontend/synth/stress_scenes.h"
#include "grtx/frontend/gaussian/gaussian_math.h"
#include "paths.h"
#include "temporary_folder.h"

namespace grtx::frontend {
namespace {

/// Largest absolute errors that the format's quantisation allows.
struct Tolerance {
  glm::dvec3 position{0.0};
  glm::dvec3 log_scale{0.0};
  double least_log_scale = -std::numeric_limits<double>::infinity();  ///< smaller ones are raised to it
  double rotation = 0.0;                                              ///< 1 - |dot product|
  double opacity = 0.0;
  glm::dvec3 colour{0.0};  ///< of SH band 0 as a colour, 0.5 + 0.2821 f_dc
  bool clamped_colour = false;
  double harmonics = 0.0;
  double largest_harmonic = 1.0;  ///< larger ones are lowered to it
};

// Steps: 1/4096, 1/16, 2/255 and sqrt(1/2)/511 (rotations), 1/255; colours 1/255 of the range 1 / 0.15; SH in 4 bits.
Tolerance spz(unsigned version) {
  Tolerance t{
      .position = glm::dvec3(0.5 / 4096 + 1e-6), .log_scale = glm::dvec3(1.0 / 32 + 1e-5), .least_log_scale = -10.0};
  // Version 2 computes w from x, y and z: where w is about 0, an error of 1/255 in each leaves 0.12 of w.
  t.rotation = version == 2 ? 7e-3 : 2e-6;
  t.opacity = 0.5 / 255 + 1e-6;
  t.colour = glm::dvec3(0.28209479177387814 * 0.5 / 255 / 0.15 + 1e-5);
  t.harmonics = 8.5 / 128 + 1e-5;
  return t;
}

template <typename Value>
glm::dvec3 range(const Scene& scene, Value&& value) {
  glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
  for (std::size_t i = 0; i < scene.size(); ++i) {
    const glm::dvec3 v = value(i);
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], v[axis]);
      high[axis] = std::max(high[axis], v[axis]);
    }
  }
  return high - low;
}

glm::dvec3 log_scale(const Scene& scene, std::size_t i) {
  const glm::vec3& s = scene.scale[i];
  return {std::log(s.x), std::log(s.y), std::log(s.z)};
}

glm::dvec3 colour(const Scene& scene, std::size_t i) {
  const float* sh = &scene.sh[i * 3 * scene.sh_coefficients()];
  return 0.5 + 0.28209479177387814 * glm::dvec3(sh[0], sh[1], sh[2]);
}

glm::dvec3 position(const Scene& scene, std::size_t i) { return glm::dvec3(scene.mean[i]) + scene.offset; }

/// 11, 10 and 11 bits over a chunk of 256 Gaussians; the range of the whole scene bounds the chunk's.
Tolerance compressed_ply(const Scene& scene) {
  const glm::dvec3 half_step(0.5 / 2047, 0.5 / 1023, 0.5 / 2047);
  Tolerance t{.position = half_step * range(scene, [&](std::size_t i) { return position(scene, i); }) + 1e-5,
              .log_scale = half_step * range(scene, [&](std::size_t i) { return log_scale(scene, i); }) + 1e-5,
              .rotation = 4e-6,
              .opacity = 0.5 / 255 + 1e-6,
              .colour = 0.5 / 255 * range(scene, [&](std::size_t i) { return colour(scene, i); }) + 1e-5,
              .harmonics = 1.0 / 64 + 1e-5,
              .largest_harmonic = 4.0};
  return t;
}

/// Colours and opacities are bytes, cut off; rotations bytes of steps 1/128.
Tolerance splat() {
  Tolerance t{.position = glm::dvec3(1e-6),
              .log_scale = glm::dvec3(1e-5),
              .rotation = 2e-4,
              .opacity = 1.0 / 255 + 1e-6,
              .colour = glm::dvec3(1.0 / 255 + 1e-6),
              .clamped_colour = true};
  return t;
}

/// Writers reorder rows: each Gaussian is compared with the one that lies nearest, and each must be found once.
void expect_same_gaussians(const Scene& source, const Scene& read, const Tolerance& tolerance) {
  ASSERT_EQ(read.size(), source.size());
  ASSERT_EQ(read.sh_degree, source.sh_degree);
  std::vector<bool> found(source.size(), false);
  for (std::size_t i = 0; i < read.size(); ++i) {
    std::size_t nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < source.size(); ++j) {
      const double distance = glm::length(position(read, i) - position(source, j));
      if (distance < least && !found[j]) {
        least = distance;
        nearest = j;
      }
    }
    found[nearest] = true;
    const glm::dvec3 place = position(source, nearest), scales = log_scale(source, nearest);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(position(read, i)[axis], place[axis], tolerance.position[axis]) << i;
      EXPECT_NEAR(log_scale(read, i)[axis], std::max(scales[axis], tolerance.least_log_scale),
                  tolerance.log_scale[axis])
          << i;
      double expected = colour(source, nearest)[axis];
      if (tolerance.clamped_colour) expected = std::clamp(expected, 0.0, 1.0);
      EXPECT_NEAR(colour(read, i)[axis], expected, tolerance.colour[axis]) << i;
    }
    EXPECT_LE(1.0 - std::abs(glm::dot(glm::dquat(read.rotation[i]), glm::dquat(source.rotation[nearest]))),
              tolerance.rotation)
        << i;
    EXPECT_NEAR(read.opacity[i], source.opacity[nearest], tolerance.opacity) << i;
    const std::size_t coefficients = std::size_t{3} * source.sh_coefficients();
    for (std::size_t k = 3; k < coefficients; ++k) {
      const double expected = static_cast<double>(source.sh[nearest * coefficients + k]);
      EXPECT_NEAR(static_cast<double>(read.sh[i * coefficients + k]),
                  std::clamp(expected, -tolerance.largest_harmonic, tolerance.largest_harmonic), tolerance.harmonics)
          << i << ' ' << k;
    }
    if (testing::Test::HasFailure()) return;
  }
}

/// Byte formats turn opacities below half a byte step into 0, a logit of -infinity, which loading drops and counts.
Scene without_zero_opacity(const Scene& all) {
  Scene kept;
  kept.sh_degree = all.sh_degree;
  kept.offset = all.offset;
  const auto stride = static_cast<std::ptrdiff_t>(3 * all.sh_coefficients());
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all.opacity[i] * 255.0f < 0.5f) continue;
    kept.mean.push_back(all.mean[i]);
    kept.scale.push_back(all.scale[i]);
    kept.rotation.push_back(all.rotation[i]);
    kept.opacity.push_back(all.opacity[i]);
    const auto sh = all.sh.begin() + static_cast<std::ptrdiff_t>(i) * stride;
    kept.sh.insert(kept.sh.end(), sh, sh + stride);
  }
  return kept;
}

void expect_same_but_zero_opacity(const Scene& source, const Scene& read, const Tolerance& tolerance) {
  const Scene kept = without_zero_opacity(source);
  const auto dropped = read.report.dropped.find("opacity logit -infinity");
  EXPECT_EQ(dropped == read.report.dropped.end() ? 0 : dropped->second, source.size() - kept.size());
  expect_same_gaussians(kept, read, tolerance);
}

constexpr SceneReadOptions kRawAxes{true};

std::string fixture(const std::string& name) { return grtx::paths::source_dir() + "/tests/data/converters/" + name; }

class IndependentWriter : public testing::TestWithParam<const char*> {};

TEST_P(IndependentWriter, BytesDecodeToTheSource) {
  const std::string file = GetParam();
  const Scene source = load_scene(fixture("src" + file.substr(1, 1) + ".ply"));
  const Scene read = load_scene(fixture(file), kRawAxes);
  const std::string format = file.substr(3);
  expect_same_gaussians(source, read,
                        format == "splat"            ? splat()
                        : format == "compressed.ply" ? compressed_ply(source)
                                                     : spz(static_cast<unsigned>(format[1] - '0')));
}

INSTANTIATE_TEST_SUITE_P(Fixtures, IndependentWriter,
                         testing::Values("d0.v2.spz", "d3.v2.spz", "d0.v3.spz", "d3.v3.spz", "d0.v4.spz", "d3.v4.spz",
                                         "d0.compressed.ply", "d3.compressed.ply", "d0.splat"),
                         [](const testing::TestParamInfo<const char*>& param) {
                           std::string name = param.param;
                           for (char& c : name) c = c == '.' ? '_' : c;
                           return name;
                         });

/// Numbers that two programs computed from the same bytes.
Tolerance decoded() {
  Tolerance t;
  t.position = t.log_scale = t.colour = glm::dvec3(2e-6);
  t.rotation = t.opacity = t.harmonics = 2e-6;
  t.largest_harmonic = 1e9;
  return t;
}

// splat-transform's own reading of its .sog, as .ply: its quantisation is in both.
TEST(IndependentReader, SogDecodesToTheSame) {
  for (const char* name : {"d0", "d3"}) {
    SCOPED_TRACE(name);
    const Scene theirs = load_scene(fixture(name + std::string(".sog.ply")));
    expect_same_but_zero_opacity(theirs, load_scene(fixture(name + std::string(".sog"))), decoded());
    if (HasFailure()) return;
  }
}

// splat-transform's reading of what GaussianSplats3D wrote, as .ply: three levels of compression, 18 buckets.
TEST(IndependentReader, KsplatDecodesToTheSame) {
  for (const char* name : {"d3.l0", "d3.l1", "d3.l2"}) {
    SCOPED_TRACE(name);
    const Scene theirs = load_scene(fixture(name + std::string(".ksplat.ply")));
    expect_same_gaussians(theirs, load_scene(fixture(name + std::string(".ksplat"))), decoded());
    if (HasFailure()) return;
  }
}

TEST(IndependentReader, FolderOfSogIsTheArchive) {
  const Scene folder = load_scene(fixture("../sog_lod/0_0")), file = load_scene(fixture("../sog_lod/0_0/meta.json"));
  test::expect_same_scene(folder, file);
  EXPECT_EQ(folder.hash, file.hash);
  EXPECT_EQ(folder.name, "0_0");
}

// lod-meta.json over d3 (level 0) and d0's Gaussians with harmonics of degree 3 left at 0 (level 1).
TEST(IndependentReader, StreamedSogGivesTheLevelAskedFor) {
  const std::string lod = fixture("../sog_lod");
  const Scene unit = load_scene(lod + "/0_0");
  SceneReadOptions options;
  test::expect_same_scene(load_scene(lod, options), unit);
  options.sog_lod = 1;
  const Scene coarse = load_scene(lod + "/lod-meta.json", options);
  EXPECT_EQ(coarse.report.rows, 40U);
  EXPECT_NE(coarse.hash, load_scene(lod).hash);
  options.sog_lod = 2;
  EXPECT_EQ(test::error_of([&] { load_scene(lod, options); }),
            "lodLevels: has 2 levels of detail, 0 the finest; not 2");
}

TEST(IndependentWriterOfGltf, GivesTheSourceItself) {
  for (const std::string degree : {"0", "3"}) {
    expect_same_gaussians(load_scene(fixture("src" + degree + ".ply")), load_scene(fixture("d" + degree + ".glb")),
                          decoded());
  }
}

class SplatTransform : public testing::Test {
 protected:
  void SetUp() override {
    const char* named = std::getenv("GRTX_SPLAT_TRANSFORM");
    if (named == nullptr) {
      GTEST_SKIP() << "GRTX_SPLAT_TRANSFORM does not name the program splat-transform (npm, 3.7.0)";
    }
    program_ = named;
  }

  std::string path(const std::string& name) const { return folder_.path(name); }
  void convert(const std::string& options, const std::string& from, const std::string& to) const {
    const std::string command = "'" + program_ + "' -q -w " + options + " '" + from + "' '" + to + "'";
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
  }

  std::string program_;
  const grtx::test::TemporaryFolder folder_;
};

TEST_F(SplatTransform, ItsFilesDecodeToTheSource) {
  for (const char* preset : {"flat", "object"}) {
    for (const unsigned degree : {0u, 1u, 3u}) {
      synthesise({preset, 700, 3, degree}, path("source.ply"));  // three chunks of a compressed .ply
      convert("", path("source.ply"), path("plain.ply"));
      convert("", path("source.ply"), path("packed.compressed.ply"));
      convert("--spz-version 3", path("source.ply"), path("v3.spz"));
      convert("--spz-version 4", path("source.ply"), path("v4.spz"));
      const Scene source = load_scene(path("source.ply"));
      const std::string where = std::string(preset) + " degree " + std::to_string(degree);
      SCOPED_TRACE(where);
      Tolerance exact;
      exact.position = exact.log_scale = exact.colour = glm::dvec3(2e-6);
      exact.position *= 1.0 + glm::length(range(source, [&](std::size_t i) { return position(source, i); }));
      exact.rotation = exact.opacity = exact.harmonics = 1e-6;
      exact.largest_harmonic = 1e9;
      expect_same_gaussians(source, load_scene(path("plain.ply")), exact);
      expect_same_but_zero_opacity(source, load_scene(path("packed.compressed.ply")), compressed_ply(source));
      // .spz holds coordinates up to 2048; the background of flat may lie beyond.
      if (std::string(preset) == "object") {
        expect_same_but_zero_opacity(source, load_scene(path("v3.spz"), kRawAxes), spz(3));
        expect_same_but_zero_opacity(source, load_scene(path("v4.spz"), kRawAxes), spz(4));
      }
      if (HasFailure()) return;
    }
  }
}

TEST_F(SplatTransform, ItReadsWhatWeRead) {
  for (const char* file : {"d0.splat", "d0.v2.spz", "d3.v2.spz", "d3.v3.spz", "d3.v4.spz", "d3.compressed.ply"}) {
    SCOPED_TRACE(file);
    const std::string fixture = grtx::paths::source_dir() + "/tests/data/converters/" + file;
    convert("", fixture, path("theirs.ply"));
    Tolerance close{.position = glm::dvec3(1e-5)};
    close.log_scale = close.colour = glm::dvec3(1e-5);
    close.rotation = 1e-6;
    if (std::string(file) == "d0.splat") close.rotation = 2e-4;  // (b - 128) / 128 here, 2 b / 255 - 1 there
    close.opacity = close.harmonics = 1e-5;
    close.largest_harmonic = 1e9;
    expect_same_gaussians(load_scene(path("theirs.ply")), load_scene(fixture, kRawAxes), close);
  }
}

}  // namespace
}  // namespace grtx::frontend
