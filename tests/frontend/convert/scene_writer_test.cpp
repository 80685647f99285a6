// SPDX-License-Identifier: Apache-2.0
// What is written reads as what it was: .ply and .usda to the bit, .spz within its steps.
#include "grtx/frontend/convert/scene_writer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "frontend/scene/scene_bytes.h"
#include "grtx/frontend/synth/synth.h"

namespace grtx::frontend {
namespace {

using test::error_of;
using test::TemporaryPath;

RawRows generated(unsigned degree) {
  const TemporaryPath path(".ply");
  synthesise({"object", 200, 5, degree}, path.str());
  std::filesystem::remove(std::filesystem::path(path.str()).replace_extension(".cameras.json"));
  return load_rows(path.str(), {});
}

void expect_equal(const RawRows& read, const RawRows& rows) {
  EXPECT_EQ(read.sh_degree, rows.sh_degree);
  EXPECT_EQ(read.x, rows.x);
  EXPECT_EQ(read.y, rows.y);
  EXPECT_EQ(read.z, rows.z);
  EXPECT_EQ(read.log_scale, rows.log_scale);
  EXPECT_EQ(read.rotation, rows.rotation);
  EXPECT_EQ(read.opacity_logit, rows.opacity_logit);
  EXPECT_EQ(read.sh, rows.sh);
}

TEST(SceneWriter, PlyKeepsEveryNumber) {
  for (unsigned degree = 0; degree <= 3; ++degree) {
    RawRows rows = generated(degree);
    rows.opacity_logit[3] = -std::numeric_limits<float>::infinity();  // kept, too: dropping is the reader's
    const TemporaryPath path(".ply");
    write_ply(rows, path.str());
    const RawRows read = load_rows(path.str(), {});
    expect_equal(read, rows);
  }
}

TEST(SceneWriter, UsdaKeepsEveryNumber) {
  for (unsigned degree = 0; degree <= 3; ++degree) {
    RawRows rows = generated(degree);
    rows.opacity_logit[3] = -std::numeric_limits<float>::infinity();
    rows.opacity_logit[4] = std::numeric_limits<float>::infinity();
    rows.log_scale[7] = -17.3F;
    for (std::size_t i = 0; i < rows.x.size(); ++i) {  // a .ply holds floats
      rows.x[i] = static_cast<double>(static_cast<float>(rows.x[i]));
    }
    const TemporaryPath path(".usda");
    EXPECT_EQ(write_usda(rows, path.str()), 0U);
    const RawRows read = load_rows(path.str(), {});
    expect_equal(read, rows);
  }
}

TEST(SceneWriter, UsdaLeavesOutWhatIsNotFinite) {
  RawRows rows = generated(0);
  rows.x[7] = std::numeric_limits<double>::quiet_NaN();
  rows.log_scale[30] = 500.0F;  // row 10: linear, beyond the largest float
  const TemporaryPath path(".usda");
  EXPECT_EQ(write_usda(rows, path.str()), 2U);
  EXPECT_EQ(load_rows(path.str(), {}).x.size(), rows.x.size() - 2);
}

TEST(SceneWriter, SpzIsWithinItsSteps) {
  for (unsigned degree = 0; degree <= 3; ++degree) {
    const RawRows rows = generated(degree);
    const TemporaryPath path(".spz");
    EXPECT_EQ(write_spz(rows, path.str()), 0U);
    const RawRows read = load_rows(path.str(), {});
    ASSERT_EQ(read.x.size(), rows.x.size());
    ASSERT_EQ(read.sh_degree, degree);
    const std::size_t harmonics = std::size_t{degree + 1} * (degree + 1) * 3;
    for (std::size_t i = 0; i < rows.x.size(); ++i) {
      EXPECT_NEAR(read.x[i], rows.x[i], 0.5 / 4096);
      EXPECT_NEAR(read.y[i], rows.y[i], 0.5 / 4096);
      EXPECT_NEAR(read.z[i], rows.z[i], 0.5 / 4096);
      const auto opacity = [](float logit) { return 1.0 / (1.0 + std::exp(-static_cast<double>(logit))); };
      EXPECT_NEAR(opacity(read.opacity_logit[i]), opacity(rows.opacity_logit[i]), 0.5 / 255 + 1e-6);
      double dot = 0.0, norm = 0.0;
      for (std::size_t c = 0; c < 4; ++c) {
        dot += static_cast<double>(read.rotation[i * 4 + c]) * static_cast<double>(rows.rotation[i * 4 + c]);
        norm += static_cast<double>(rows.rotation[i * 4 + c]) * static_cast<double>(rows.rotation[i * 4 + c]);
      }
      EXPECT_NEAR(std::abs(dot) / std::sqrt(norm), 1.0, 2e-6);
      for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(read.log_scale[i * 3 + c], std::max(-10.0f, rows.log_scale[i * 3 + c]), 1.0 / 32 + 1e-5);
        const double colour = std::clamp(static_cast<double>(rows.sh[i * harmonics + c]), -0.5 / 0.15, 0.5 / 0.15);
        EXPECT_NEAR(static_cast<double>(read.sh[i * harmonics + c]), colour, 0.5 / 255 / 0.15 + 1e-5);
      }
      for (std::size_t k = 3; k < harmonics; ++k) {
        // -1 has a byte, +1 has none, and the format's axes turn some signs.
        const float kept = read.sh[i * harmonics + k], was = rows.sh[i * harmonics + k];
        if (std::abs(was) > 127.0f / 128.0f) {
          EXPECT_GE(kept * (was > 0.0f ? 1.0f : -1.0f), 127.0f / 128.0f);
        } else {
          EXPECT_NEAR(kept, was, 0.5 / 128 + 1e-6);
        }
      }
    }
  }
}

TEST(SceneWriter, SpzLeavesOutWhatIsNotFiniteAndWidensItsSteps) {
  RawRows rows = generated(0);
  rows.x[7] = std::numeric_limits<double>::quiet_NaN();
  rows.log_scale[30] = std::numeric_limits<float>::infinity();  // row 10
  rows.z[0] = 5000.0;                                           // beyond 2^23 steps of 1/4096: 1/1024 holds it
  const TemporaryPath path(".spz");
  EXPECT_EQ(write_spz(rows, path.str()), 2U);
  const RawRows read = load_rows(path.str(), {});
  EXPECT_EQ(read.x.size(), rows.x.size() - 2);
  EXPECT_EQ(read.z[0], 5000.0);
}

TEST(SceneWriter, RefusesWhatTheFormatsDoNotHold) {
  RawRows rows = generated(0);
  rows.y[1] = 1e7;
  EXPECT_EQ(error_of([&] { write_spz(rows, "F.spz"); }), "position: must be at most 2^23 to be written as .spz");
  rows.sh_degree = 4;
  EXPECT_EQ(error_of([&] { write_ply(rows, "F.ply"); }), "SH degree: must be at most 3 to be written");
  EXPECT_EQ(error_of([&] { write_usda(rows, "F.usda"); }), "SH degree: must be at most 3 to be written");
}

}  // namespace
}  // namespace grtx::frontend
