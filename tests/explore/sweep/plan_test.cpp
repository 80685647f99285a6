// SPDX-License-Identifier: Apache-2.0
// A sweep's plan: what it says, and the one line that a wrong one gets.
#include "grtx/explore/sweep/plan.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "explore/sweep/fake_tracer_rules.h"
#include "grtx/base/atomic_file.h"
#include "paths.h"
#include "temporary_folder.h"

namespace grtx::explore {
namespace {

class SweepPlanTest : public testing::Test {
 protected:
  SweepPlan read(const std::string& text) {
    write_file(path, text);
    return load_plan(path, test::FakeTracerRules());
  }
  const grtx::test::TemporaryFolder own_folder;
  const std::string folder = own_folder.path(), path = own_folder.path("plan.toml");
};

constexpr const char* kScene = "[[scene]]\npreset = 'object'\ncount = 100\n";  // lines 1 to 3

TEST_F(SweepPlanTest, SaysWhatIsVaried) {
  write_file(folder + "/base.toml", "[gpu]\nsms = 3\n");
  const SweepPlan plan = read(R"(
base = "base.toml"
designs = ["baseline", "grtx"]
mode = "cycle"
confirm = "windows"
[limits]
seconds = 60
memory_mb = 500.5
[[scene]]
name = "one"
file = "scenes/a.ply"
cameras = "../c.json"
views = [0, 3]
width = 32
[[scene]]
preset = "flat"
count = 5000
seed = 9
[tracer]
k = 16
[set]
gpu.resident_warps = 4
"l1.bytes" = 4096
[grid]
rt.warp_buffer.entries = [2, 4]
"l1.latency" = {from = 10, to = 20, steps = 2, integer = true}
[[point]]
"rt.scheduler.policy" = "round_robin"
tracer.k = 4
[latin]
count = 5
seed = 2
[latin.axes]
rt.box.count = {values = [1, 2]}
)");
  EXPECT_EQ(plan.base, folder + "/base.toml");
  EXPECT_EQ(plan.designs, (std::vector<std::string>{"baseline", "grtx"}));
  EXPECT_EQ(plan.confirm, "windows");
  EXPECT_EQ(plan.limits.seconds, 60);
  EXPECT_EQ(plan.limits.memory_mb, 500.5);
  ASSERT_EQ(plan.scenes.size(), 2U);
  EXPECT_EQ(plan.scenes[0].file, folder + "/scenes/a.ply");
  EXPECT_EQ(plan.scenes[0].cameras, (std::filesystem::path(folder) / "../c.json").lexically_normal());
  EXPECT_EQ(plan.scenes[0].views, (std::vector<unsigned>{0, 3}));
  EXPECT_EQ(plan.scenes[1].name, "flat-5000-9");
  ASSERT_EQ(plan.settings.size(), 3U);
  EXPECT_EQ(plan.settings[0].first, "tracer.k");
  EXPECT_EQ(plan.settings[1].first, "gpu.resident_warps");
  ASSERT_EQ(plan.points.size(), 4U + 1U + 5U);
  EXPECT_EQ(plan.points[1][0].first, "rt.warp_buffer.entries");
  EXPECT_EQ(plan.points[1][1].second, 20);
  EXPECT_EQ(plan.points[4][1].second, 4);
}

TEST_F(SweepPlanTest, WithoutAxesIsOnePoint) { EXPECT_EQ(read(kScene).points.size(), 1U); }

TEST_F(SweepPlanTest, ThePlansOfTheProjectAreRead) {
  const SweepPlan plan = load_plan(grtx::paths::source_dir() + "/configs/sweeps/pizza.toml", test::FakeTracerRules());
  EXPECT_EQ(plan.points.size(), 60U);
  const std::string rooms = grtx::paths::source_dir() + "/configs/sweeps/rooms_layouts.toml";
  EXPECT_FALSE(load_plan(rooms, test::FakeTracerRules()).points.empty());
}

TEST_F(SweepPlanTest, AStructureOfItsOwnIsNoNamedDesign) {
  EXPECT_TRUE(read(std::string(kScene) + "[tracer]\naccel = 'ellipsoid'\n").designs.empty());
}

TEST_F(SweepPlanTest, AWrongPlanGetsOneLineWithPlaceAndRule) {
  const std::string scene = kScene;
  const struct {
    std::string text, place, rule;
  } cases[] = {
      {"", "scene", "at least one [[scene]] is needed"},
      {"x = = 1\n", "line 1", ""},
      {"area = 'cost.rt_mm2'\n" + scene, "line 1", "area: unknown 'cost.rt_mm2', the nearest is 'cost.mm2'"},
      {scene + "[gird]\n", "line 4", "unknown key 'gird', the nearest is 'grid'"},
      {scene + "[grid]\nl1.byts = [1]\n", "line 5", "unknown key 'l1.byts', the nearest is 'l1.bytes'"},
      {scene + "[grid]\nl1.bytes = [1]\n", "line 5", "l1.bytes: must be 32 to 67108864, not 1"},
      {scene + "[grid]\nl1.bytes = []\n", "line 5", "l1.bytes: the list of values is empty"},
      {scene + "[grid]\nl1.bytes = 64\n", "line 5", "l1.bytes: must be a list of values or a range {from, to, ...}"},
      {scene + "[grid]\nl1.bytes = {from = 64, to = 128, integer = true}\n", "line 5",
       "l1.bytes: a range in a grid needs steps"},
      {scene + "[grid]\nl1.bytes = {from = 64, to = 128, steps = 3}\n", "line 5", "l1.bytes: must be an integer"},
      {scene + "[grid]\nl1.bytes = {from = 128, to = 64, steps = 3}\n", "line 5",
       "l1.bytes: from must not be above to"},
      {scene + "[grid]\nl1.bytes = {from = 0, to = 64, steps = 3, scale = 'log'}\n", "line 5",
       "l1.bytes: a logarithmic range must be above 0"},
      {scene + "[grid]\nl1.bytes = {from = 64, to = 128, step = 3}\n", "line 5",
       "unknown key 'l1.bytes.step', the nearest is 'l1.bytes.steps'"},
      {scene + "[grid]\nrt.scheduler.policy = ['oldest']\n", "line 5", "rt.scheduler.policy: must be one of"},
      {scene + "[grid]\ntracer.kk = [4]\n", "line 5", "tracer.kk: unknown tracer option 'kk', the nearest is 'k'"},
      {scene + "[grid]\ntracer.k = [4, 5000]\n", "line 5", "tracer.k: k: must be 1 to 2048"},
      {scene + "[tracer]\nk = [4]\n", "line 5", "tracer.k: must be a single value"},
      {scene + "[random]\nseed = 1\n[random.axes]\nl1.bytes = [64]\n", "line 4", "random: count is needed"},
      {scene + "[latin]\ncount = 3\n", "line 4", "latin: axes are needed"},
      {scene + "[latin]\ncount = 0\n", "line 5", "latin.count: must be an integer, 1 to 4294967295"},
      {"designs = ['grtx', 'swi']\n" + scene, "line 1", "designs: unknown 'swi', the nearest is 'sw'"},
      {"designs = ['grtx']\n" + scene + "[tracer]\naccel = 'tri20'\n", "line 1", "designs: name accel and checkpoint"},
      {scene + "[[point]]\ndesign = 'wlak'\n", "line 5", "design: unknown 'wlak', the nearest is 'walk'"},
      {scene + "[grid]\ndesign = ['sw', 'gtrx']\n", "line 5", "design: unknown 'gtrx', the nearest is 'grtx'"},
      {scene + "[[point]]\ndesign = 'walk'\ntracer.accel = 'tri20'\n", "", "design: names accel and checkpoint"},
      {scene + "[tracer]\ncheckpoint = 'on'\n[[point]]\ndesign = 'sw'\n", "", "design: names accel and checkpoint"},
      {scene + "[set]\ndesign = 'walk'\n", "line 5", "unknown key 'design'"},
      {"[[scene]]\nfile = 'a.ply'\n", "line 1", "scene: cameras are needed"},
      {"[[scene]]\nwidth = 3\n", "line 1", "scene: needs either file and cameras, or preset"},
      {"[[scene]]\npreset = 'a'\nfile = 'a.ply'\n", "line 1", "scene: needs either file and cameras, or preset"},
      {"[[scene]]\npreset = 'a'\nwidht = 3\n", "line 3", "unknown key 'scene.widht', the nearest is 'scene.width'"},
      {"[[scene]]\npreset = 'a'\nwidth = -3\n", "line 3", "scene.width: must be an integer, 0 to 65536"},
      {scene + scene, "line 4", "scene: two scenes are named 'object-100-1'"},
      {"base = 'none.toml'\n" + scene, "line 1", "base: "},
      {scene + "[limits]\nminutes = 1\n", "line 5", "unknown key 'limits.minutes'"},
      {scene + "[grid]\nl1.bytes = {from = 64, to = 1000, steps = 900, integer = true}\n"
               "l2.queue = {from = 1, to = 2000, steps = 2000, integer = true}\n",
       "line 4", "grid: 1800000 points, of which a plan may have 100000"},
      {scene + "[random]\ncount = 4000000000\n[random.axes]\nl1.bytes = [64]\n", "line 5",
       "random.count: 4000000000 points, of which a plan may have 100000"},
      {"designs = ['baseline', 'grtx']\n" + scene +
           "views = [0, 1]\n[random]\ncount = 30000\n[random.axes]\nl1.bytes = [64]\n",
       "", "2 views x 2 designs x 30000 combinations: 120000 points, of which a plan may have 100000"},
  };
  for (const auto& c : cases) {
    try {
      read(c.text);
      ADD_FAILURE() << "accepted:\n" << c.text;
    } catch (const Error& error) {
      EXPECT_EQ(error.file(), path) << c.text;
      EXPECT_EQ(error.place(), c.place) << c.text << error.what();
      EXPECT_EQ(error.rule().substr(0, c.rule.size()), c.rule) << c.text;
    }
  }
}

}  // namespace
}  // namespace grtx::explore
