// SPDX-License-Identifier: Apache-2.0
// Orders of children and the test of popped nodes through the program: the same image, sound traces, and a stack
// without its t in the cost.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "apps/program.h"
#include "paths.h"

namespace grtx::e2e {
namespace {

using ::testing::HasSubstr;

class Orders : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(folder_.run("synth --preset flat --count 1500 --seed 3 -o s.ply --quiet").code, 0);
  }
  Outcome run(const std::string& options) {
    return folder_.run("run --scene s.ply --cameras s.cameras.json --width 16 --height 8 --config '" +
                       grtx::paths::source_dir() + "/configs/small.toml' " + options);
  }
  nlohmann::json json(const std::string& name) { return nlohmann::json::parse(folder_.read(name)); }

  Folder folder_;
};

TEST_F(Orders, GiveTheSameImageInTheFourDesigns) {
  const Outcome usual = run("--child-order near_first --pop-test on -o usual");
  ASSERT_EQ(usual.code, 0) << usual.err;
  EXPECT_THAT(usual.out, HasSubstr(" % of rays end by early termination; there are "));
  EXPECT_THAT(folder_.read("usual/report.html"), HasSubstr("as many hits as are processed"));
  const Outcome other = run("--child-order vulkan_sim --pop-test off -o other");
  ASSERT_EQ(other.code, 0) << other.err;
  EXPECT_EQ(folder_.read("usual/image.png"), folder_.read("other/image.png"));
  const auto expected = json("usual/results.json"), results = json("other/results.json");
  EXPECT_TRUE(results.at("images_identical").get<bool>());
  EXPECT_TRUE(results.at("violations").empty());
  for (const char* design : {"baseline", "sw", "hw", "grtx"}) {
    const auto value = [&](const nlohmann::json& of, const char* name) {
      return of.at("designs").at(design).at(name).at("value").get<double>();
    };
    EXPECT_GT(value(expected, "gpu.rt.culls"), 0.0) << design;
    EXPECT_EQ(value(results, "gpu.rt.culls"), 0.0) << design;
    EXPECT_NE(value(results, "gpu.rt.node_visits"), value(expected, "gpu.rt.node_visits")) << design;
    for (const char* name : {"tracer.blended", "tracer.processed", "tracer.hits", "tracer.hits_behind_end"}) {
      EXPECT_EQ(value(results, name), value(expected, name)) << design << " " << name;
    }
    EXPECT_GE(value(results, "tracer.hits_behind_end"), 1.0);
    EXPECT_EQ(value(results, "tracer.ert_share"), value(results, "tracer.terminated") / value(results, "tracer.rays"));
    EXPECT_EQ(results.at("inputs").at(design).at("pop_test"), "off");
    EXPECT_FALSE(expected.at("inputs").at(design).contains("pop_test")) << "as on record";
    EXPECT_EQ(folder_.run(std::string("trace-check --quiet other/") + design + ".grtx").code, 0);
  }
}

// 8 warps x 32 lanes x 8 entries of an address (8 B), and with the test a t (4 B).
TEST_F(Orders, WithoutPopTestAStackEntryCostsFourBytesLess) {
  const auto stack = [&](const std::string& options) {
    EXPECT_EQ(folder_.run("cost --csv cost.csv " + options).code, 0);
    const std::string csv = folder_.read("cost.csv");
    const std::string row = ".warp_buffer,1,stack,SRAM,";
    return std::stoull(csv.substr(csv.find(row) + row.size()));
  };
  EXPECT_EQ(stack(""), 8u * 32 * 8 * 96);
  EXPECT_EQ(stack("--pop-test off"), 8u * 32 * 8 * 64);
}

TEST_F(Orders, UnknownNamesAreRefused) {
  const Outcome order = run("--child-order vulkan -o x");
  EXPECT_EQ(order.code, 2);
  EXPECT_THAT(order.err, HasSubstr("vulkan_sim"));
  EXPECT_EQ(run("--pop-test maybe -o x").code, 2);
}

}  // namespace
}  // namespace grtx::e2e
