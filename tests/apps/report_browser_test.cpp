// SPDX-License-Identifier: Apache-2.0
// Reports in a real browser: report_browser.mjs looks, this says what must be there. Needs node, Chromium and the
// packages that the build fetched for the charts; skips without.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "apps/browser.h"
#include "grtx/base/atomic_file.h"
#include "paths.h"
#include "sweep_database.h"

namespace grtx::e2e {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class ReportInBrowser : public InBrowser {
 protected:
  ReportInBrowser() : InBrowser("report_browser.mjs") {}

  void expect_sound(const json& found) {
    EXPECT_THAT(found.at("messages"), IsEmpty()) << found.at("messages");  // no error, no warning
    EXPECT_THAT(found.at("requests"), IsEmpty()) << found.at("requests");
    EXPECT_LE(found.at("overflow").at("1280").get<int>(), 0);
    EXPECT_LE(found.at("overflow").at("390").get<int>(), 0);
    EXPECT_LE(found.at("overflow").at("print").get<int>(), 0);  // the speed-ups lost what binds them
    EXPECT_THAT(found.at("wide_drawings"), IsEmpty()) << found.at("wide_drawings");
    EXPECT_EQ(found.at("charts"), found.at("drawings"));
    EXPECT_THAT(found.at("cut"), IsEmpty()) << found.at("cut");                    // cards show all that they say
    EXPECT_THAT(found.at("broken_words"), IsEmpty()) << found.at("broken_words");  // on a phone, into letters
    EXPECT_THAT(found.at("unreadable"), IsEmpty()) << found.at("unreadable");
    EXPECT_THAT(found.at("broken_figures"), IsEmpty()) << found.at("broken_figures");
    EXPECT_THAT(found.at("odd_colours"), IsEmpty()) << found.at("odd_colours");
    EXPECT_THAT(found.at("hiding_boxes"), IsEmpty()) << found.at("hiding_boxes");
    // A row of a phone's table names the column of each figure.
    EXPECT_GT(found.at("stacked").at("cells").get<int>(), 0);
    EXPECT_THAT(found.at("stacked").at("unnamed"), IsEmpty()) << found.at("stacked").at("unnamed");
    for (const auto& [name, begin] : {std::pair("SVG", "<svg"), std::pair("PNG", "PNG")}) {
      EXPECT_THAT(found.at("exports").at(name).at("begin").get<std::string>(), testing::EndsWith(begin));
      EXPECT_GT(found.at("exports").at(name).at("bytes").get<int>(), 2000);
      EXPECT_FALSE(found.at("exports").at(name).at("variables").get<bool>());  // colours that no file knows
    }
    EXPECT_THAT(found.at("exports").at("CSV").at("first_line").get<std::string>(), testing::HasSubstr(","));
    EXPECT_TRUE(found.at("labelled").get<bool>());
    EXPECT_EQ(found.at("tables"), found.at("described_tables"));
    EXPECT_THAT(found.at("repeated_ids"), IsEmpty()) << found.at("repeated_ids");
    EXPECT_NE(found.at("light"), found.at("dark"));
    EXPECT_EQ(found.at("pdf").at("begin"), "%PDF-");
    EXPECT_GT(found.at("pdf").at("bytes").get<int>(), 20000);
    EXPECT_EQ(found.at("plain").at("tables"), found.at("tables"));  // all tables are there without JavaScript
    EXPECT_EQ(found.at("plain").at("svgs"), 0);
    EXPECT_EQ(found.at("plain").at("notes"), found.at("drawn_by_script"));
  }
};

std::set<int> set_of(const json& list) { return list.get<std::set<int>>(); }

std::set<int> numbers(const json& labels) {
  std::set<int> ids;
  for (const json& label : labels) ids.insert(std::stoi(label.get<std::string>().substr(1)));
  return ids;
}

TEST_F(ReportInBrowser, ASweepIsDrawnHoveredAndBrushed) {
  const Outcome cost = folder.run("cost --json");
  ASSERT_EQ(cost.code, 0) << cost.err;
  testing_sweep::make_grid(folder.path("sweep.sqlite"), json::parse(cost.out).at("config").dump());
  const Outcome made = folder.run("report sweep.sqlite --image " + grtx::paths::source_dir() +
                                  "/docs/images/heatmap_cycles.png -o sweep.html");
  ASSERT_EQ(made.code, 0) << made.err;
  const json found = look("sweep.html");
  ASSERT_TRUE(found.contains("plain"));
  expect_sound(found);

  std::set<int> done;
  for (int id = 1; id <= 60; ++id) {
    if (id != 7 && id != 31) done.insert(id);
  }
  EXPECT_EQ(found.at("points").size(), 58u);
  EXPECT_EQ(set_of(found.at("points")), done);
  EXPECT_EQ(found.at("plain").at("rows"), 58);
  EXPECT_EQ(found.at("colours"), 5);          // warp buffers of 4, 8, 12, 16, 20
  EXPECT_EQ(found.at("colours_by_last"), 2);  // k of 4 and 8

  // Point number id of the grid: 12 points a warp buffer, 4 a lane count, 2 an L1 size.
  const int id = found.at("hover").at("id").get<int>();
  const int warps = 4 * (1 + (id - 1) / 12), lanes = std::array{1, 4, 16}[static_cast<std::size_t>((id - 1) / 4 % 3)];
  const int bytes = ((id - 1) / 2 % 2 == 0 ? 64 : 128) * 1024, k = (id - 1) % 2 == 0 ? 4 : 8;
  std::string tooltip = found.at("hover").at("text").get<std::string>();
  std::replace_if(
      tooltip.begin(), tooltip.end(), [](char c) { return c == '\t' || c == '\n'; }, ' ');
  tooltip.erase(std::unique(tooltip.begin(), tooltip.end(), [](char a, char b) { return a == ' ' && b == ' '; }),
                tooltip.end());
  EXPECT_THAT(tooltip, HasSubstr("point #" + std::to_string(id) + " "));
  EXPECT_THAT(tooltip, HasSubstr("rt.warp_buffer.entries " + std::to_string(warps) + " "));
  EXPECT_THAT(tooltip, HasSubstr("rt.checkpoint.lanes " + std::to_string(lanes) + " "));
  EXPECT_THAT(tooltip, HasSubstr("l1.bytes " + std::to_string(bytes) + " "));
  EXPECT_THAT(tooltip, HasSubstr(" k " + std::to_string(k) + " "));

  EXPECT_EQ(numbers(found.at("front_bars")), set_of(found.at("front")));
  const json& box = found.at("box");
  EXPECT_GT(box.at("inside").size(), 10u);
  EXPECT_LT(box.at("inside").size(), 50u);
  EXPECT_EQ(set_of(box.at("rows")), set_of(box.at("inside")));                                    // the table
  EXPECT_EQ(numbers(box.at("bars")).size(), std::min<std::size_t>(24, box.at("inside").size()));  // the bars
  EXPECT_EQ(box.at("lines"), box.at("inside").size());  // and the parallel coordinates follow
  EXPECT_EQ(box.at("status"), std::to_string(box.at("inside").size()) + " of 58 points chosen");
  const json& zoom = found.at("zoom");
  EXPECT_NE(zoom.at("chosen"), zoom.at("before"));
  EXPECT_EQ(zoom.at("whole"), zoom.at("before"));
  EXPECT_NE(zoom.at("wheel"), zoom.at("before"));
  EXPECT_EQ(set_of(found.at("after_all").at("rows")), done);
  EXPECT_EQ(numbers(found.at("after_all").at("bars")), set_of(found.at("front")));
  const json& keys = found.at("keyboard");
  ASSERT_EQ(keys.at("rows").size(), 1u);
  EXPECT_THAT(keys.at("text").get<std::string>(), HasSubstr("#" + std::to_string(keys.at("rows")[0].get<int>()) + " "));
  EXPECT_NE(keys.at("zoomed"), keys.at("labels"));
  EXPECT_EQ(keys.at("after"), "58 points");
  EXPECT_EQ(found.at("filter").at("marks").size(), 30u);  // of k = 8; #7 and #31 have k = 4
  EXPECT_EQ(set_of(found.at("filter").at("rows")), set_of(found.at("filter").at("marks")));
  EXPECT_THAT(found.at("lines_over"), testing::Contains("16"));  // checkpoint lanes
  for (const json& effect : found.at("effects")) {
    // 160 us less of some 2,000: k = 8 against k = 4, which comes first.
    if (effect.at("key") != "k" || effect.at("value") != "8") continue;
    EXPECT_NEAR(effect.at("factor").get<double>(), 0.93, 0.03);
  }
  const std::vector<double> sorted = found.at("sorted").get<std::vector<double>>();
  EXPECT_TRUE(std::is_sorted(sorted.begin(), sorted.end()));
}

// The chart library's tooltip shows a field of the name "image" as the picture at that address: hovering fetched it.
TEST_F(ReportInBrowser, ACoordinateCalledImageIsTextAndNoRequest) {
  testing_sweep::make_grid(folder.path("foreign.sqlite"), "{}");
  testing_sweep::execute(folder.path("foreign.sqlite"),
                         "UPDATE point SET coordinates = json_set(json_remove(coordinates, '$.k'), '$.image', "
                         "'http://127.0.0.1:9/' || json_extract(coordinates, '$.k') || '.png')");
  const Outcome made = folder.run("report foreign.sqlite -o foreign.html");
  ASSERT_EQ(made.code, 0) << made.err;
  const json found = look("foreign.html");
  ASSERT_TRUE(found.contains("plain"));
  EXPECT_THAT(found.at("requests"), IsEmpty()) << found.at("requests");
  EXPECT_THAT(found.at("messages"), IsEmpty()) << found.at("messages");  // nor one that the page's policy refused
  EXPECT_THAT(found.at("hover").at("text").get<std::string>(),
              testing::ContainsRegex("image.*http://127.0.0.1:9/[48].png"));
}

// Two scenes, three machines: 1 to 3 in the room, 4 to 6 in the hall, where times are ten to fifty times as long.
TEST_F(ReportInBrowser, PointsOfTwoScenesAreComparedWithinEach) {
  json points = json::array();
  for (int id = 1; id <= 6; ++id) {
    const int machine = (id - 1) % 3;
    const double time = (id <= 3 ? 10.0 : 100.0) * (1 + machine * machine * (id <= 3 ? 1 : 6));
    points.push_back({{"id", id},
                      {"scene", id <= 3 ? "room" : "hall"},
                      {"coordinates", {{"l1.bytes", 32768 << machine}, {"rt.checkpoint.lanes", 4}}},
                      {"values",
                       {{"gpu.time_us", time},
                        {"cost.mm2", 9 - machine},
                        {"gpu.energy_nj_per_ray", 5 + machine},
                        {"gpu.rt.selections", 10},
                        {"gpu.rt.stall.memory", time}}}});
  }
  testing_sweep::make_points(folder.path("two.sqlite"), points);
  const Outcome made = folder.run("report two.sqlite -o two.html");
  ASSERT_EQ(made.code, 0) << made.err;
  const json found = look("two.html");
  ASSERT_TRUE(found.contains("plain"));
  expect_sound(found);
  EXPECT_THAT(found.at("titles"), ElementsAre("point", "view", "time, µs", "speed-up", "chip, mm²", "RT unit, mm²",
                                              "nJ per ray", "on the front of", "cycles", "L1 hit rate of nodes",
                                              "DRAM MB", "chip, mm², low – high", "l1.bytes"));  // lanes never vary
  const json& views = found.at("views");
  ASSERT_EQ(views.size(), 3u);
  const std::set<int> expected[3] = {{-3, -2, -1}, {1, 2, 3}, {4, 5, 6}};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(set_of(views[i].at("marks")), expected[i]);
    EXPECT_EQ(set_of(views[i].at("rows")), expected[i]);
    EXPECT_EQ(set_of(views[i].at("bars")), expected[i]);  // all are on the front
  }
  EXPECT_THAT(views[1].at("speedups"), ElementsAre("1.00×", "0.50×", "0.20×"));  // 10, 20, 50 µs
  EXPECT_THAT(views[2].at("speedups"), ElementsAre("1.00×", "0.14×", "0.04×"));  // 100, 700, 2500
  EXPECT_THAT(views[0].at("speedups"), ElementsAre("1.00×", "0.27×", "0.09×"));  // their geometric means
  EXPECT_THAT(found.at("over_second"), ElementsAre("7.00×", "1.00×", "0.28×"));
  EXPECT_THAT(views[2].at("axes"), testing::Not(testing::Contains("0")));  // fitted to the data; from 0 on request
  EXPECT_THAT(found.at("from_zero"), testing::Contains("0"));
  EXPECT_EQ(found.at("plain").at("rows"), 9);
}

TEST_F(ReportInBrowser, ARunIsDrawn) {
  ASSERT_EQ(folder.run("synth --preset object --count 1500 --seed 7 -o s.ply --quiet").code, 0);
  const Outcome run = folder.run("run --scene s.ply --cameras s.cameras.json --view 0 --width 16 --height 8 --config " +
                                 grtx::paths::source_dir() + "/configs/small.toml --latency --quiet -o out");
  ASSERT_EQ(run.code, 0) << run.err;
  const Outcome made = folder.run("report out/results.json out/results.json -o run.html");
  ASSERT_EQ(made.code, 0) << made.err;
  const json found = look("run.html");
  ASSERT_TRUE(found.contains("plain"));
  expect_sound(found);
  // "take --" ended a line on a phone, "69" another.
  EXPECT_THAT(found.at("whole_figures"), testing::Contains(testing::MatchesRegex("--width [0-9]+")));
  EXPECT_THAT(found.at("whole_figures"), testing::Contains(testing::EndsWith(" %")));
  // Twice the bytes of L2 and DRAM, what two speed-ups are made of, and four courses over time; ratios, stalls, energy.
  EXPECT_EQ(found.at("charts"), 19);
}

}  // namespace
}  // namespace grtx::e2e
