// SPDX-License-Identifier: Apache-2.0
// A search's plan: what it says, and the one line that a wrong one gets.
#include "grtx/explore/search/search_plan.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "explore/sweep/fake_tracer_rules.h"
#include "grtx/base/atomic_file.h"
#include "paths.h"
#include "temporary_folder.h"

namespace grtx::explore {
namespace {

using Values = std::vector<SweepValue>;

class SearchPlanTest : public testing::Test {
 protected:
  SearchPlan read(const std::string& text) {
    write_file(path, text);
    return load_search_plan(path, test::FakeTracerRules());
  }
  const grtx::test::TemporaryFolder folder;
  const std::string path = folder.path("plan.toml");
};

TEST_F(SearchPlanTest, SaysWhatMayBeChosenWhatIsWantedAndWhatMustHold) {
  const SearchPlan plan = read(R"(
[[scene]]
preset = "object"
width = 32
height = 32
[[scene]]
preset = "flat"
role = "evaluation"
[set]
gpu.sms = 2
[[parameter]]
key = "l1.bytes"
values = [65536, 32768]
[[parameter]]
key = "rt.warp_buffer.entries"
min = 2
max = 9
step = 3
[[parameter]]
key = "gpu.core_mhz"
min = 1000
max = 1500.5
step = 250.25
kind = "categorical"
[[parameter]]
key = "design"
values = ["sw", "grtx"]
[[parameter]]
key = "tracer.k"
values = [4, 8]
[[objective]]
value = "gpu.time_us"
[[objective]]
value = "cost.mm2"
[[constraint]]
rule = "cost.rt_unit_mm2 <= 1.1 * reference"
[[constraint]]
rule = "gpu.rt.occupancy>=2e-1"
[[constraint]]
rule = "gpu.energy_nj <= reference"
[reference]
tracer.k = 8
design = "sw"
[search]
seed = 5
population = 12
candidates = 500
confirm = "windows"
margin = 0.02
path = false
screening_scale = 0.5
[search.screening]
l1.latency = 30
)");
  EXPECT_EQ(plan.common.mode, "cycle");
  ASSERT_EQ(plan.common.scenes.size(), 2U);
  EXPECT_FALSE(plan.common.scenes[0].evaluation);
  EXPECT_TRUE(plan.common.scenes[1].evaluation);
  ASSERT_EQ(plan.parameters.size(), 5U);
  EXPECT_EQ(plan.parameters[0].values, (Values{65536, 32768}));
  EXPECT_TRUE(plan.parameters[0].ordered);
  EXPECT_EQ(plan.parameters[1].values, (Values{2, 5, 8}));
  EXPECT_TRUE(plan.parameters[1].values[0].is_number_integer());
  EXPECT_EQ(plan.parameters[2].values, (Values{1000.0, 1250.25, 1500.5}));
  EXPECT_FALSE(plan.parameters[2].ordered);
  EXPECT_FALSE(plan.parameters[3].ordered);
  EXPECT_EQ(plan.objectives[1].value, "cost.mm2");
  EXPECT_EQ(plan.common.area, kChipArea);  // an objective comes before a constraint
  EXPECT_EQ(plan.constraints[0].value, "cost.rt_unit_mm2");
  EXPECT_TRUE(plan.constraints[0].at_most && plan.constraints[0].relative);
  EXPECT_EQ(plan.constraints[0].bound, 1.1);
  EXPECT_FALSE(plan.constraints[1].at_most || plan.constraints[1].relative);
  EXPECT_EQ(plan.constraints[1].bound, 0.2);
  EXPECT_TRUE(plan.constraints[2].relative);
  EXPECT_EQ(plan.constraints[2].bound, 1.0);
  EXPECT_EQ(plan.reference, (Coordinates{{"design", "sw"}, {"tracer.k", 8}}));  // in the order of the parameters
  EXPECT_EQ(plan.screening, (Coordinates{{"l1.latency", 30}}));
  EXPECT_EQ(plan.confirm, "windows");
  EXPECT_EQ(plan.seed, 5U);
  EXPECT_EQ(plan.population, 12U);
  EXPECT_EQ(plan.candidates, 500U);
  EXPECT_EQ(plan.margin, 0.02);
  EXPECT_EQ(plan.screening_scale, 0.5);
  EXPECT_FALSE(plan.path);
}

TEST_F(SearchPlanTest, ThePlansOfTheProjectAreRead) {
  unsigned plans = 0;
  for (const auto& file : std::filesystem::directory_iterator(grtx::paths::source_dir() + "/configs/searches")) {
    EXPECT_GE(load_search_plan(file.path().string(), test::FakeTracerRules()).parameters.size(), 2U) << file.path();
    ++plans;
  }
  EXPECT_GE(plans, 1U);
}

TEST_F(SearchPlanTest, AWrongPlanGetsOneLineWithPlaceAndRule) {
  const std::string scene = "[[scene]]\npreset = 'object'\n";                                  // lines 1, 2
  const std::string parameter = "[[parameter]]\nkey = 'l1.bytes'\nvalues = [32768, 65536]\n";  // 3 to 5
  const std::string rest = "[reference]\n[search]\ngenerations = 3\n[[objective]]\nvalue = 'cost.mm2'\n";
  const std::string whole = scene + parameter + rest;  // lines 1 to 10
  EXPECT_EQ(read(whole).generations, 3U);
  const struct {
    std::string text, place, rule;
  } cases[] = {
      {"x = = 1\n", "line 1", ""},
      {whole + "[serach]\n", "line 11", "unknown key 'serach', the nearest is 'search'"},
      {whole + "[grid]\n", "line 11", "unknown key 'grid', the nearest is"},
      {parameter + rest, "scene", "at least one [[scene]] is needed"},
      {scene + "role = 'evaluation'\n" + parameter + rest, "scene", "at least one [[scene]] with role"},
      {scene + "role = 'evalution'\n" + parameter + rest, "line 3", "scene.role: unknown 'evalution', the nearest is"},
      {scene + rest, "parameter", "at least one [[parameter]] is needed"},
      {scene + parameter + "[reference]\n[search]\ngenerations = 3\n", "objective", "at least one [[objective]]"},
      {scene + parameter + "[search]\ngenerations = 3\n[[objective]]\nvalue = 'cost.mm2'\n", "reference",
       "[reference] is needed"},
      {scene + parameter + "[reference]\n[[objective]]\nvalue = 'cost.mm2'\n", "search",
       "[search] needs either generations or candidates"},
      {whole + "[[parameter]]\nkey = 'l1.byts'\nvalues = [1, 2]\n", "line 13",
       "unknown key 'l1.byts', the nearest is 'l1.bytes'"},
      {whole + "[[parameter]]\nkey = 'tracer.kk'\nvalues = [1, 2]\n", "line 13",
       "tracer.kk: unknown tracer option 'kk', the nearest is 'k'"},
      {whole + "[[parameter]]\nkey = 'l2.bytes'\nvalues = [1]\n", "line 13", "l2.bytes: "},
      {whole + "[[parameter]]\nkey = 'tracer.k'\nvalues = [4]\n", "line 13", "tracer.k: needs two values or more"},
      {whole + "[[parameter]]\nkey = 'tracer.k'\nvalues = [4, 8, 4]\n", "line 13",
       "tracer.k: the value 4 is there twice"},
      {whole + "[[parameter]]\nkey = 'tracer.k'\nvalues = [4, 9999]\n", "line 13", "tracer.k: k: must be 1 to 2048"},
      {whole + "[[parameter]]\nkey = 'tracer.k'\nmin = 4\n", "line 11", "tracer.k: needs either values, or min, max"},
      {whole + "[[parameter]]\nkey = 'tracer.k'\nmin = 9\nmax = 4\nstep = 1\n", "line 11", "tracer.k: min must not be"},
      {whole + "[[parameter]]\nkey = 'tracer.k'\nmax = 4\nvalues = [4, 8]\n", "line 11",
       "tracer.k: needs either values"},
      {whole + "[[parameter]]\nkey = 'tracer.k'\nvales = [4, 8]\n", "line 13",
       "unknown key 'parameter.vales', the nearest is 'parameter.values'"},
      {whole + "[[parameter]]\nvalues = [4, 8]\n", "line 11", "parameter: key is needed"},
      {whole + parameter, "line 11", "parameter: two have the key 'l1.bytes'"},
      {whole + "[[parameter]]\nkey = 'design'\nvalues = ['sw', 'gtrx']\n", "line 13",
       "design: unknown 'gtrx', the nearest is 'grtx'"},
      {whole + "[[parameter]]\nkey = 'design'\nvalues = ['sw', 'hw']\n[tracer]\naccel = 'tri20'\n", "line 13",
       "design: names accel and checkpoint"},
      {whole + "[[objective]]\nvalue = 'cost.mm2'\n", "line 11", "objective: two are cost.mm2"},
      {whole + "[[objective]]\ngoal = 'cost.mm2'\n", "line 12", "unknown key 'objective.goal'"},
      {whole + "[[constraint]]\nrule = 'cost.mm2 < 3'\n", "line 12", "constraint.rule: must be VALUE <= NUMBER or"},
      {whole + "[[constraint]]\nrule = 'cost.mm2 <= 3 * base'\n", "line 12", "constraint.rule: must be VALUE <= "},
      {whole + "[[constraint]]\nrule = 'cost.mm2 <= 3.1.4'\n", "line 12", "constraint.rule: must be VALUE <= "},
      {scene + parameter + "[reference]\nl2.bytes = 4096\n", "line 7",
       "reference: 'l2.bytes' is no [[parameter]], the nearest is 'l1.bytes'"},
      {scene + parameter + "[reference]\nl1.bytes = 1\n", "line 7", "l1.bytes: must be 32 to"},
      {whole + "[search.screening]\nl1.latenyc = 4\n", "line 12", "unknown key 'l1.latenyc', the nearest is"},
      {scene + parameter + "[reference]\n[search]\npopulation = 10\n", "line 8",
       "search.population: must be a multiple"},
      {scene + parameter + "[reference]\n[search]\npopulation = 4\n", "line 8",
       "search.population: must be an integer"},
      {scene + parameter + "[reference]\n[search]\nmargin = 2\n", "line 8", "search.margin: must be 0 to 1"},
      {scene + parameter + "[reference]\n[search]\nscreening_scale = 0\n", "line 8", "search.screening_scale: must be"},
      {scene + parameter + "[reference]\n[search]\npath = 1\n", "line 8", "search.path: must be true or false"},
      {scene + parameter + "[reference]\n[search]\ncandidate = 1\n", "line 8",
       "unknown key 'search.candidate', the nearest is 'search.candidates'"},
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
