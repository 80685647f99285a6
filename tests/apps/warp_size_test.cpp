// SPDX-License-Identifier: Apache-2.0
// Warp size and mapping through the program: the same image, and traces that the model takes their warps from.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "apps/program.h"
#include "paths.h"

namespace grtx::e2e {
namespace {

using ::testing::HasSubstr;

TEST(WarpSizeOption, ChangesTheWarpsButNotTheImage) {
  Folder folder;
  ASSERT_EQ(folder.run("synth --preset flat --count 500 --seed 3 -o s.ply --quiet").code, 0);
  const auto trace = [&](const std::string& name, const std::string& options) {
    return folder.run("trace --quiet --scene s.ply --cameras s.cameras.json --width 16 --height 8 -o " + name +
                      ".grtx --image " + name + ".pfm " + options);
  };
  ASSERT_EQ(trace("usual", "").code, 0);
  const auto warps = [&](const std::string& name) {
    EXPECT_EQ(folder
                  .run("sim --quiet --config '" + grtx::paths::source_dir() + "/configs/small.toml' " + name +
                       ".grtx --stats " + name + ".json")
                  .code,
              0);
    const auto stats = nlohmann::json::parse(folder.read(name + ".json"));
    return stats.at("stats").at("gpu.simt.warps").at("value").get<unsigned>();
  };
  EXPECT_EQ(warps("usual"), 16U * 8 / 32);
  ASSERT_EQ(trace("small", "--warp-size 8").code, 0);
  EXPECT_EQ(warps("small"), 16U * 8 / 8);
  ASSERT_EQ(trace("linear", "--warp-size 16 --mapping linear").code, 0);
  EXPECT_EQ(warps("linear"), 16U * 8 / 16);
  for (const char* name : {"small", "linear"}) {
    EXPECT_THAT(folder.run(std::string("compare usual.pfm ") + name + ".pfm").out, HasSubstr("identical"));
  }
  const Outcome refused = trace("odd", "--warp-size 12");
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("--warp-size"));
}

}  // namespace
}  // namespace grtx::e2e
