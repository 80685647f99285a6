// SPDX-License-Identifier: Apache-2.0
// Runs on one page: what joins, what is averaged, and what stands beside a figure.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "grtx/explore/sweep/designs.h"
#include "grtx/report/page/report.h"
#include "grtx/report/page/sections.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "temporary_folder.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

ordered_json inputs_of(const std::string& scene, const std::string& camera, const std::string& design) {
  return {{"trace.scene", scene + ".ply"},
          {"trace.scene_hash", scene},
          {"trace.camera", camera},
          {"trace.camera_hash", scene + camera},
          {"accel", design == "grtx" ? "tlas-tri20" : "tri20"},
          {"checkpoint", design == "grtx" ? "on" : "off"},
          {"k", "8"},
          {"width", "64"},
          {"height", "64"},
          {"mode", "cycle"}};
}

/// results.json of a run of two designs.
ordered_json results(const std::string& machine, const std::string& scene, double baseline, double grtx) {
  ordered_json document = {{"schema", "grtx.run/1"}, {"version", "1"}, {"model_version", 7}, {"machine", machine}};
  document["config"] = sim::config_json(sim::load_config("", {}));
  for (const auto& [design, cycles] : {std::pair("baseline", baseline), std::pair("grtx", grtx)}) {
    for (const char* statistic : {"gpu.cycles", "gpu.rt.selections", "gpu.rt.stall.memory"}) {
      document["designs"][design][statistic] = {{"value", cycles}, {"unit", "cycles"}, {"description", "of the run"}};
    }
    document["inputs"][design] = inputs_of(scene, "0", design);
  }
  return document;
}

/// Statistics of one grtx sim of a design.
ordered_json statistics(const std::string& name, double cycles, const std::string& k = "8") {
  const explore::Design& design = explore::design_of(name);
  const sim::GpuConfig machine = sim::load_config("", {}),
                       own = explore::with_keys_of(design, explore::k_of(design), machine, {});
  ordered_json inputs = inputs_of("hall", "0", "baseline");
  inputs.update({{"accel", design.accel}, {"checkpoint", design.checkpoint ? "on" : "off"}, {"k", k}});
  inputs["machine"] = design.keys.empty() ? "paper" : "paper, changed";
  for (const auto& [option, value] : design.tracer) {
    if (option != "k" || !design.keys.empty()) inputs[option] = value;
  }
  const ordered_json all = {{"value", cycles}, {"unit", "cycles"}, {"description", "of the run"}};
  return {{"schema", "grtx.stats/1"},
          {"model_version", 7},
          {"config", sim::config_json(own)},
          {"stats", {{"gpu.cycles", all}}},
          {"inputs", inputs}};
}

class RunsApart : public testing::Test {
 protected:
  std::string write(const std::string& name, const ordered_json& document) {
    folder.write(name, document.dump());
    return folder.path(name);
  }
  /// The page without what every page has.
  static std::string page(const std::vector<std::string>& files) {
    ReportOptions options;
    options.inputs = files;
    const std::string whole = report_page(options);
    const std::size_t begin = whole.find("<main");
    return whole.substr(begin, whole.find("</main>") - begin);
  }
  const grtx::test::TemporaryFolder folder;
};

// The demo's machines had a mean, 2.79 times, and "model / paper" of it.
TEST_F(RunsApart, SeveralMachinesHaveNoMean) {
  const std::string html = page(
      {write("a.json", results("paper", "hall", 4000, 1000)), write("b.json", results("modern", "hall", 2000, 1000))});
  EXPECT_THAT(html, Not(HasSubstr("mean of 2")));
  EXPECT_THAT(html, Not(HasSubstr(">mean<")));
  EXPECT_THAT(html,
              AllOf(HasSubstr("<th scope=\"col\" class=\"n\">paper</th><th scope=\"col\" class=\"n\">modern</th>"),
                    HasSubstr("4.00× <span class=\"share\">0.92</span>"),  // of the paper's 4.36
                    HasSubstr("2.00× <span class=\"share\">0.46</span>")));
}

// "they are not compared with each other": four numbers had to be found in two tables.
TEST_F(RunsApart, AnEstimateBesideCycleModeSaysWhetherItHolds) {
  ordered_json estimate = results("paper", "hall", 4000, 1010);
  for (const char* design : {"baseline", "grtx"}) {
    estimate["inputs"][design].update({{"mode", "windows"}, {"windows.seed", "1"}});
    const double cycles = estimate["designs"][design]["gpu.cycles"]["value"].get<double>();
    estimate["designs"][design]["gpu.windows.cycles_low"]["value"] = 0.9 * cycles;
    estimate["designs"][design]["gpu.windows.cycles_high"]["value"] = 1.1 * cycles;
  }
  estimate["speedup_interval"]["grtx"] = {{"low", 3.9}, {"high", 3.99}, {"confidence", 0.95}};
  const std::string windows = write("windows.json", estimate);
  const std::string html = page({windows, write("cycle.json", results("paper", "hall", 4500, 1000))});
  EXPECT_THAT(html,
              AllOf(HasSubstr("cycles of baseline</th><td class=\"n\">4,000</td><td class=\"n\">3,600 to 4,400</td>"
                              "<td class=\"n\">4,500</td><td><strong>no</strong></td>"),
                    HasSubstr("cycles of grtx</th><td class=\"n\">1,010</td><td class=\"n\">909 to 1,111</td>"
                              "<td class=\"n\">1,000</td><td>yes</td>"),
                    HasSubstr("speed-up of grtx over baseline</th><td class=\"n\">3.96×</td><td class=\"n\">"
                              "3.90× to 3.99×</td><td class=\"n\">4.50×</td><td><strong>no</strong>"),
                    Not(HasSubstr("not compared with each other"))));
  // Of another machine, another scene, or both estimated.
  for (const std::string& other : {write("own.json", results("own", "hall", 4500, 1000)),
                                   write("room.json", results("paper", "room", 4500, 1000)), windows}) {
    EXPECT_THAT(page({windows, other}), Not(HasSubstr("Estimates beside cycle mode"))) << other;
  }
}

// The answer of a single simulation was its warning, or nothing.
TEST_F(RunsApart, ASingleSimulationIsAnsweredToo) {
  EXPECT_THAT(page({write("g.json", statistics("grtx", 1000))}), HasSubstr("<p class=\"answer\">grtx takes <strong>"));
}

// The table of what differs had a row of designs, which were the same.
TEST_F(RunsApart, EqualDesignsAreNoDifference) {
  const std::string html = page(
      {write("a.json", results("paper", "hall", 8000, 1000)), write("b.json", results("paper", "room", 2000, 1000))});
  EXPECT_THAT(html, AllOf(HasSubstr("<th scope=\"row\">scene</th>"), Not(HasSubstr("<th scope=\"row\">designs</th>"))));
}

TEST_F(RunsApart, ScenesOfOneMachineHaveAGeometricMean) {
  const std::string html = page({write("a.json", results("paper", "hall", 8000, 1000)),
                                 write("b.json", results("paper", "room", 2000, 1000)),
                                 write("c.json", results("modern", "room", 9000, 1000))});
  EXPECT_THAT(html, HasSubstr(">geometric mean of 2 views, paper</th>"));
  // The first screen had an answer per view, and none over both.
  EXPECT_THAT(html, AllOf(HasSubstr("<h3>Both views</h3>"),
                          HasSubstr("<strong>grtx is fastest in both views</strong>: <strong>4.00 times as fast as "
                                    "baseline</strong> in the geometric mean (2.00× to 8.00×)."),
                          Not(HasSubstr("All 3 views"))));
  EXPECT_THAT(html, HasSubstr("4.00× <span class=\"share\">0.92</span>"));  // of 8 and 2
}

// Rows of 8 and 170 SMs stood under "of the run's own machine", which had 4.
TEST_F(RunsApart, BuffersOfAnotherNumberOfSmsAreNotCalledTheMachinesOwn) {
  ordered_json document = results("own", "hall", 4000, 1000);
  document["config"]["gpu.sms"] = 4;
  document["inputs"]["grtx"]["mode"] = "windows";  // which has no counters to price parts by
  EXPECT_THAT(page({write("a.json", document)}),
              AllOf(HasSubstr(", 170 SMs</th>"), HasSubstr("buffers for as many SMs as their row says")));
}

TEST_F(RunsApart, StatisticsOfAllDesignsJoinInWhateverOrder) {
  const std::string html =
      page({write("g.json", statistics("gautracer", 500)), write("x.json", statistics("grtx", 1000)),
            write("b.json", statistics("baseline", 4000)), write("w.json", statistics("walk", 400))});
  EXPECT_THAT(html, Not(HasSubstr("In what the runs differ")));
  EXPECT_THAT(html, AllOf(HasSubstr("Speed-up over baseline by design; machine paper, mode cycle"),
                          Not(HasSubstr("what binds it")),  // statistics have no bounds: an empty column
                          HasSubstr("hall, view 0, 64 × 64, k = 8, machine paper"), HasSubstr("4.00×"),
                          HasSubstr("8.00×"), HasSubstr("10.00×")));
  std::size_t at = 0;  // columns in the order of the other tables
  for (const char* design : {"baseline", "grtx", "gautracer", "walk"}) {
    const std::size_t next = html.find(std::string("<th scope=\"row\">") + design + "</th>", at);
    ASSERT_NE(next, std::string::npos) << design;
    at = next;
  }
  // Each machine that differs has a column of the configuration.
  EXPECT_THAT(html, AllOf(HasSubstr("model version 7: gautracer</th>"), HasSubstr("model version 7: walk</th>"),
                          Not(HasSubstr("model version 7: grtx</th>"))));
}

// Each design is held against all others, not against the first file alone.
TEST_F(RunsApart, ADesignThatBringsItsKDoesNotJoinTwoOthersOfDifferentK) {
  const std::string html =
      page({write("g.json", statistics("gautracer", 500)), write("b.json", statistics("baseline", 4000, "8")),
            write("s.json", statistics("sw", 2000, "12"))});
  EXPECT_THAT(html, AllOf(HasSubstr("In what the runs differ"), HasSubstr("8.00×"), Not(HasSubstr("2.00×"))));
}

// Two copies of one file are one view: their mean would count it twice.
TEST_F(RunsApart, OneViewTwiceHasNoMean) {
  const std::string file = write("a.json", results("paper", "hall", 8000, 1000));
  EXPECT_THAT(page({file, file}), AllOf(Not(HasSubstr("geometric mean of")), HasSubstr("a.json (2)")));
}

TEST_F(RunsApart, ARunIsCalledByWhatSetsItApartAndNeverRunA) {
  const std::string html = page({write("a.json", results("paper", "hall", 4000, 1000)),
                                 write("b.json", results("paper-charged", "hall", 2000, 1000))});
  EXPECT_THAT(html, Not(HasSubstr("Run A")));
  EXPECT_THAT(html, AllOf(HasSubstr("<h3>paper</h3>"), HasSubstr("<h3>paper-charged</h3>"),
                          HasSubstr("In what the runs differ"), HasSubstr("paper-charged: grtx")));
}

// A page of one scene showed the picture that a run of another had left in the folder.
TEST_F(RunsApart, APictureOfAnEarlierRunIsNotShown) {
  const std::string png = std::string("\x89PNG\r\n\x1a\n", 8) + "of another run";
  folder.write("image.png", png);
  ordered_json document = results("paper", "hall", 4000, 1000);
  EXPECT_THAT(page({write("a.json", document)}), Not(HasSubstr("<img")));  // of results that name no picture
  document["images"] = {{{"file", "image.png"}, {"hash", "0123456789abcdef"}}};
  EXPECT_THAT(page({write("a.json", document)}),
              AllOf(Not(HasSubstr("<img")), HasSubstr("image.png beside a.json is not the picture of this run")));
  document["images"] = {{{"file", "gone.png"}, {"hash", "0123456789abcdef"}}};
  EXPECT_THAT(page({write("a.json", document)}), HasSubstr("gone.png is not beside a.json"));
  document["images"] = {{{"file", "../image.png"}, {"hash", "0123456789abcdef"}}};
  EXPECT_THROW(page({write("a.json", document)}), Error);
}

TEST_F(RunsApart, AnEstimateStandsWithItsInterval) {
  ordered_json document = results("paper", "hall", 4000, 1000);
  for (const auto& [design, low, high] : {std::tuple("baseline", 3800, 4200), std::tuple("grtx", 900, 1100)}) {
    document["inputs"][design]["mode"] = "windows";
    document["designs"][design]["gpu.windows.cycles_low"] = {{"value", low}, {"unit", "cycles"}};
    document["designs"][design]["gpu.windows.cycles_high"] = {{"value", high}, {"unit", "cycles"}};
  }
  const std::string wide = page({write("a.json", document)});
  EXPECT_THAT(wide,
              AllOf(HasSubstr("1,000 <span class=\"interval\">(900 to 1,100)</span>"),
                    HasSubstr("4.00× <span class=\"interval\">(3.45× to 4.67×)</span>"),  // 3800 / 1100 and 4200 / 900
                    HasSubstr("mode windows"), HasSubstr("Estimated from a sample")));
  document["speedup_interval"]["grtx"] = {{"low", 3.9}, {"high", 4.1}};  // of pairs, as grtx run knows it
  EXPECT_THAT(page({write("a.json", document)}), HasSubstr("4.00× <span class=\"interval\">(3.90× to 4.10×)</span>"));
}

// The same note stood four times on a page.
TEST_F(RunsApart, WhatLimitsAFigureStandsOnceWithTheAnswerAndOtherSectionsLeadThere) {
  ordered_json document = results("paper", "hall", 4000, 1000);
  document["notes"]["baseline"] = {{{"id", "no-hits"}, {"text", "no ray met a <Gaussian>"}}};
  document["notes"]["grtx"] = document["notes"]["baseline"];
  const std::string html = page({write("a.json", document)});
  const std::string note = "<strong>Mind (baseline, grtx):</strong> no ray met a &lt;Gaussian&gt;";
  for (const char* section : {"headline", "paper", "run1", "bars"}) {
    const std::size_t begin = html.find(std::string("<section id=\"") + section);
    ASSERT_NE(begin, std::string::npos) << section;
    const std::string text = html.substr(begin, html.find("</section>", begin) - begin);
    EXPECT_EQ(text.find(note) != std::string::npos, section == std::string("headline")) << section;
    EXPECT_THAT(text, HasSubstr("What limits these figures")) << section;
  }
}

}  // namespace
}  // namespace grtx::report
