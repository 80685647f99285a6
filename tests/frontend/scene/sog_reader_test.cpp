// SPDX-License-Identifier: Apache-2.0
// SOG: each value of a texel, by its formula, and what is refused.
#include "grtx/frontend/scene/readers.h"

#include <webp/encode.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "frontend/scene/scene_bytes.h"

namespace grtx::frontend {
namespace {

using test::error_of;
using test::TemporaryPath;

/// A folder with one Gaussian, all of whose bytes are known.
class SogReader : public testing::Test {
 protected:
  SogReader() : folder_("") {
    std::filesystem::create_directories(folder_.str());
    nlohmann::json codebook = nlohmann::json::array();
    for (int i = 0; i < 256; ++i) codebook.push_back(i / 64.0 - 2.0);
    meta_ = {{"version", 2},
             {"count", 1},
             {"means", {{"mins", {-1.0, 0.0, 2.0}}, {"maxs", {1.0, 1.0, 2.0}}, {"files", {"l.webp", "u.webp"}}}},
             {"scales", {{"codebook", codebook}, {"files", {"s.webp"}}}},
             {"quats", {{"files", {"q.webp"}}}},
             {"sh0", {{"codebook", codebook}, {"files", {"c.webp"}}}}};
    texels("l.webp", 1, {{0x34, 0xff, 0, 255}});
    texels("u.webp", 1, {{0x12, 0xff, 0, 255}});
    texels("s.webp", 1, {{0, 64, 255, 255}});
    texels("q.webp", 1, {{255, 128, 0, 253}});  // x is left out: w y z follow
    texels("c.webp", 1, {{128, 192, 64, 51}});
  }

  void texels(const std::string& name, int width, const std::vector<std::array<std::uint8_t, 4>>& rgba) const {
    std::uint8_t* bytes = nullptr;
    // Lossless, and "exact" is not needed: alpha is never 0 here.
    const std::size_t size =
        WebPEncodeLosslessRGBA(rgba.front().data(), width, static_cast<int>(rgba.size()) / width, width * 4, &bytes);
    write_file(path(name), std::string_view(reinterpret_cast<const char*>(bytes), size));
    WebPFree(bytes);
  }
  std::string path(const std::string& name) const { return folder_.str() + "/" + name; }
  RawRows read() const {
    write_file(path("meta.json"), meta_.dump());
    return load_rows(folder_.str(), {});
  }
  std::string refusal() const {
    return error_of([this] { read(); });
  }

  TemporaryPath folder_;
  nlohmann::json meta_;
};

TEST_F(SogReader, TexelsDecodeByTheFormulas) {
  const RawRows rows = read();
  ASSERT_EQ(rows.x.size(), 1U);
  // sign(v) (exp(|v|) - 1) of v between mins and maxs in steps of 1/65535.
  EXPECT_DOUBLE_EQ(rows.x[0], -std::expm1(1.0 - 2.0 * 0x1234 / 65535.0));
  EXPECT_DOUBLE_EQ(rows.y[0], std::expm1(1.0));
  EXPECT_DOUBLE_EQ(rows.z[0], std::expm1(2.0));
  EXPECT_EQ(rows.log_scale, (std::vector<float>{-2.0f, -1.0f, 255.0f / 64.0f - 2.0f}));
  EXPECT_EQ(rows.sh, (std::vector<float>{0.0f, 1.0f, -1.0f}));
  EXPECT_FLOAT_EQ(rows.opacity_logit[0], static_cast<float>(std::log(0.2 / 0.8)));
  const double w = 1.0 / std::numbers::sqrt2, y = (128 / 255.0 * 2 - 1) / std::numbers::sqrt2, z = -w;
  EXPECT_FLOAT_EQ(rows.rotation[0], static_cast<float>(w));
  EXPECT_NEAR(rows.rotation[1], std::sqrt(std::max(0.0, 1.0 - w * w - y * y - z * z)), 1e-6);
  EXPECT_FLOAT_EQ(rows.rotation[2], static_cast<float>(y));
  EXPECT_FLOAT_EQ(rows.rotation[3], static_cast<float>(z));
}

TEST_F(SogReader, HarmonicsComeFromThePaletteByLabel) {
  nlohmann::json codebook = meta_["sh0"]["codebook"];
  meta_["shN"] = {{"count", 66}, {"bands", 1}, {"codebook", codebook}, {"files", {"p.webp", "n.webp"}}};
  std::vector<std::array<std::uint8_t, 4>> palette(std::size_t{192} * 2, {0, 0, 0, 255});
  palette[192 + 3] = {64, 128, 192, 255};  // label 65: second row, second entry, first coefficient
  palette[192 + 5] = {1, 2, 3, 255};
  texels("p.webp", 192, palette);
  texels("n.webp", 1, {{65, 0, 0, 255}});
  const RawRows rows = read();
  EXPECT_EQ(rows.sh_degree, 1U);
  EXPECT_EQ(rows.sh, (std::vector<float>{0.0f, 1.0f, -1.0f, -1.0f, 0.0f, 1.0f, -2.0f, -2.0f, -2.0f, 1.0f / 64 - 2,
                                         2.0f / 64 - 2, 3.0f / 64 - 2}));
  texels("n.webp", 1, {{66, 0, 0, 255}});
  EXPECT_EQ(refusal(), "Gaussian 0: its SH label must be below 66");
  meta_["shN"]["bands"] = 2;
  EXPECT_EQ(refusal(), "p.webp: must be 512 texels wide for degree 2");
}

/// Version 1, as the format's first writer made it: no version, no count, 256 equal steps in place of a codebook.
class SogVersion1 : public SogReader {
 protected:
  SogVersion1() {
    meta_.erase("version");
    meta_.erase("count");
    meta_["means"]["shape"] = {1, 3};
    meta_["scales"] = {{"mins", {-3.0, -2.0, -1.0}}, {"maxs", {0.0, 2.0, 4.0}}, {"files", {"s.webp"}}};
    meta_["sh0"] = {{"mins", {-1.0, 0.0, 1.0, -5.0}}, {"maxs", {1.0, 2.0, 5.0, 5.0}}, {"files", {"c.webp"}}};
  }
};

TEST_F(SogVersion1, BytesAreStepsBetweenMinsAndMaxsOfTheirChannel) {
  const RawRows rows = read();
  ASSERT_EQ(rows.x.size(), 1U);
  EXPECT_DOUBLE_EQ(rows.x[0], -std::expm1(1.0 - 2.0 * 0x1234 / 65535.0));
  EXPECT_EQ(rows.log_scale, (std::vector<float>{-3.0f, static_cast<float>(-2.0 + 4.0 * (64 / 255.0)), 4.0f}));
  EXPECT_EQ(rows.sh,
            (std::vector<float>{static_cast<float>(-1.0 + 2.0 * (128 / 255.0)), static_cast<float>(2.0 * (192 / 255.0)),
                                static_cast<float>(1.0 + 4.0 * (64 / 255.0))}));
  EXPECT_FLOAT_EQ(rows.opacity_logit[0], -5.0f + 10.0f * 51 / 255);  // not through the sigmoid
  EXPECT_FLOAT_EQ(rows.rotation[0], static_cast<float>(1.0 / std::numbers::sqrt2));
  EXPECT_EQ(rows.sh_degree, 0U);
}

TEST_F(SogVersion1, TheWidthOfThePaletteSaysTheDegree) {
  meta_["shN"] = {{"mins", -1.0}, {"maxs", 1.0}, {"quantization", 8}, {"files", {"p.webp", "n.webp"}}};
  texels("n.webp", 1, {{65, 0, 0, 255}});
  for (const int degree : {1, 2, 3}) {
    const int coefficients = (degree + 1) * (degree + 1) - 1, width = 64 * coefficients;
    std::vector<std::array<std::uint8_t, 4>> palette(static_cast<std::size_t>(width) * 2, {0, 0, 0, 255});
    palette[static_cast<std::size_t>(width + coefficients)] = {51, 102, 255, 255};  // second row, second entry
    texels("p.webp", width, palette);
    const RawRows rows = read();
    EXPECT_EQ(rows.sh_degree, static_cast<unsigned>(degree));
    ASSERT_EQ(rows.sh.size(), static_cast<std::size_t>(coefficients + 1) * 3);
    EXPECT_FLOAT_EQ(rows.sh[3], -0.6f);
    EXPECT_FLOAT_EQ(rows.sh[4], -0.2f);
    EXPECT_FLOAT_EQ(rows.sh[5], 1.0f);
    EXPECT_FLOAT_EQ(rows.sh[6], -1.0f);
  }
  texels("n.webp", 1, {{128, 0, 0, 255}});
  EXPECT_EQ(refusal(), "Gaussian 0: its SH label must be below 128");
  meta_["shN"]["quantization"] = 6;
  EXPECT_EQ(refusal(), "shN.quantization: must be 8");
  meta_["shN"].erase("quantization");
  texels("p.webp", 64, std::vector<std::array<std::uint8_t, 4>>(64, {0, 0, 0, 255}));
  EXPECT_EQ(refusal(), "p.webp: must be 192, 512 or 960 texels wide");
  meta_["means"]["shape"] = "many";
  EXPECT_EQ(refusal(), "means.shape: must be a whole number from 0 to 268435456");
}

TEST_F(SogReader, AStreamedSceneWhoseEnvironmentIsNullHasNone) {
  write_file(path("meta.json"), meta_.dump());
  nlohmann::json lods = {{"lodLevels", 1}, {"filenames", {"meta.json"}}};
  lods["tree"]["lods"]["0"] = {{"file", 0}, {"offset", 0}, {"count", 1}};
  const auto gaussians = [&](const nlohmann::json& environment) {
    lods["environment"] = environment;
    write_file(path("lod-meta.json"), lods.dump());
    return load_rows(path("lod-meta.json"), {}).x.size();
  };
  EXPECT_EQ(gaussians(nullptr), 1U);
  EXPECT_EQ(gaussians("meta.json"), 2U);
  EXPECT_EQ(error_of([&] { gaussians(7); }), "environment: must be a file name or null");
}

TEST_F(SogReader, DamageIsRefused) {
  const nlohmann::json whole = meta_;
  const auto with = [&](const char* pointer, const nlohmann::json& value) {
    meta_ = whole;
    meta_[nlohmann::json::json_pointer(pointer)] = value;
    return refusal();
  };
  EXPECT_EQ(with("/version", 1), "version: must be 2, or not there: version 1");
  EXPECT_EQ(with("/count", -1), "count: must be a whole number from 0 to 268435456");
  EXPECT_EQ(with("/count", 2), "l.webp: has 1 texels; must have 2 to 65544");
  EXPECT_EQ(with("/scales/codebook", {1.0}), "scales.codebook: must be a list of 256 finite numbers");
  EXPECT_EQ(with("/means/mins/1", "x"), "means.mins: must be a list of 3 finite numbers");
  EXPECT_EQ(with("/means/files", {"l.webp"}), "means.files: must be a list of 2 file names");
  EXPECT_EQ(with("/quats/files/0", "../q.webp"), "../q.webp: must be a file beside it");
  EXPECT_EQ(with("/quats/files/0", "/etc/passwd"), "/etc/passwd: must be a file beside it");
  EXPECT_EQ(with("/quats/files/0", "meta.json"), "meta.json: is no WebP picture");
  meta_ = whole;
  meta_.erase("sh0");
  EXPECT_EQ(refusal(), "sh0: is missing");
  meta_ = whole;
  write_file(path("q.webp"), read_file(path("q.webp")).substr(0, 30));
  EXPECT_EQ(refusal(), "q.webp: is a damaged WebP picture");
  EXPECT_EQ(test::scene_error("PK\x03\x04garbage").substr(0, 27), ": is a damaged zip archive:");
}

// 63 KB of pictures of one colour claimed 268 million Gaussians, and got 4.4 GB.
TEST_F(SogReader, KilobytesThatClaimGigabytesAreRefused) {
  const std::vector<std::array<std::uint8_t, 4>> one_colour(std::size_t{1024} * 1024, {1, 2, 3, 255});
  for (const char* name : {"l.webp", "u.webp"}) texels(name, 1024, one_colour);
  meta_["count"] = one_colour.size();
  const std::string text = refusal();
  EXPECT_TRUE(text.starts_with("l.webp: cannot hold 1048576 Gaussians in ")) << text;
  EXPECT_TRUE(text.ends_with(" bytes together with u.webp")) << text;
}

}  // namespace
}  // namespace grtx::frontend
