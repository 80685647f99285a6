// SPDX-License-Identifier: Apache-2.0
// grtx compare: figures, JSON and the exit code of --min-psnr.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "apps/program.h"
#include "grtx/frontend/image/image.h"

namespace grtx::e2e {
namespace {

class CliCompare : public ::testing::Test {
 protected:
  CliCompare() {
    frontend::Image image(4, 2);
    frontend::write_image(folder_.path("black.pfm"), image);
    image.at(0, 0) = glm::vec3(0.5f);  // one of eight pixels: MSE = 0.25 / 8, PSNR = 10 log10(32) = 15.0515 dB
    frontend::write_image(folder_.path("spot.pfm"), image);
    frontend::write_image(folder_.path("small.pfm"), frontend::Image(2, 2));
  }
  Folder folder_;
};

TEST_F(CliCompare, PrintsFiguresAsJson) {
  const Outcome outcome = folder_.run("compare black.pfm spot.pfm --json");
  EXPECT_EQ(outcome.code, 0);
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_NEAR(json.at("psnr").get<double>(), 15.0515, 1e-4);
  EXPECT_EQ(json.at("max_error"), 0.5);
  EXPECT_EQ(json.at("different_pixels"), 1);
  EXPECT_EQ(json.at("identical"), false);
}

TEST_F(CliCompare, IdenticalImagesPassEveryLimit) {
  const Outcome outcome = folder_.run("compare black.pfm black.pfm --json --min-psnr 1000");
  EXPECT_EQ(outcome.code, 0);
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_TRUE(json.at("psnr").is_null());
  EXPECT_EQ(json.at("identical"), true);
}

TEST_F(CliCompare, ALimitThatDoesNotHoldIsExitCodeOne) {
  const Outcome outcome = folder_.run("compare black.pfm spot.pfm --min-psnr 16");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_TRUE(is_one_error_line(outcome.err)) << outcome.err;
  EXPECT_EQ(folder_.run("compare black.pfm spot.pfm --min-psnr 15").code, 0);
}

TEST_F(CliCompare, DifferentSizesAreBadInput) { EXPECT_EQ(folder_.run("compare black.pfm small.pfm").code, 2); }

}  // namespace
}  // namespace grtx::e2e
