// SPDX-License-Identifier: Apache-2.0
// Machines side by side on a page: whose times are compared, and in what machines differ.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "grtx/report/page/machine_words.h"
#include "grtx/report/page/report.h"
#include "grtx/report/page/run_results.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "temporary_folder.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// The members of results.json that belong to a machine.
ordered_json machine(const std::string& name, double baseline, double grtx, unsigned sms) {
  ordered_json document = {{"machine", name}, {"config", sim::config_json(sim::load_config("", {}))}};
  document["config"]["gpu.sms"] = sms;
  for (const auto& [design, us] : {std::pair("baseline", baseline), std::pair("grtx", grtx)}) {
    for (const auto& [statistic, value] : {std::pair("gpu.cycles", us * 1365), std::pair("gpu.time_us", us)}) {
      document["designs"][design][statistic] = {{"value", value}, {"unit", ""}, {"description", ""}};
    }
    document["inputs"][design] = {{"trace.scene", "hall.ply"},
                                  {"trace.scene_hash", "1"},
                                  {"trace.camera", "0"},
                                  {"trace.camera_hash", "2"},
                                  {"accel", design == std::string("grtx") ? "tlas-tri20" : "tri20"},
                                  {"checkpoint", design == std::string("grtx") ? "on" : "off"},
                                  {"trace.k", "8"},
                                  {"trace.child_order", name == "ada" ? "near_first" : "slot"},
                                  {"width", "64"},
                                  {"height", "64"},
                                  {"mode", "cycle"}};
  }
  return document;
}

ordered_json one(const std::string& name, double baseline, double grtx, unsigned sms) {
  ordered_json document = {{"schema", "grtx.run/1"}, {"version", "1"}, {"model_version", 7}};
  document.update(machine(name, baseline, grtx, sms));
  return document;
}

ordered_json several() {
  return {{"schema", "grtx.run/2"},
          {"version", "1"},
          {"model_version", 7},
          {"machines", {machine("paper", 4000, 1000, 8), machine("ada", 200, 100, 142)}},
          {"between_machines", {{"over", "paper"}}},
          {"images_identical", true},
          {"violations", {"grtx on ada: a law is broken"}}};
}

class SideBySide : public testing::Test {
 protected:
  std::string page(const std::vector<ordered_json>& documents) {
    ReportOptions options;
    for (const ordered_json& document : documents) {
      options.inputs.push_back(folder.path(std::to_string(options.inputs.size()) + ".json"));
      folder.write(std::to_string(options.inputs.size() - 1) + ".json", document.dump());
    }
    const std::string whole = report_page(options);
    const std::size_t begin = whole.find("<main");
    return whole.substr(begin, whole.find("</main>") - begin);
  }
  const grtx::test::TemporaryFolder folder;
};

TEST_F(SideBySide, MachinesOfARunHaveTimesRatiosAndTheKeysThatDiffer) {
  const std::string html = page({several()});
  EXPECT_THAT(
      html,
      AllOf(HasSubstr("<h3>Machines side by side</h3>"),
            HasSubstr("<th scope=\"row\">baseline</th><td class=\"n\" data-what=\"paper: time\">4.00 ms</td>"),
            HasSubstr(">0.200 ms</td><td class=\"n\" data-what=\"times as fast as on paper\">20.00×</td>"),
            HasSubstr(">0.100 ms</td><td class=\"n\" data-what=\"times as fast as on paper\">10.00×</td>"),
            HasSubstr("2 keys and options differ"), HasSubstr("<th scope=\"row\">gpu.sms</th><td>8</td><td>142</td>")));
  EXPECT_THAT(html,
              AllOf(HasSubstr("<th scope=\"row\">child_order (tracer)</th><td>slot</td><td>near_first</td>"),
                    HasSubstr("<h3>paper</h3>"), HasSubstr("<h3>ada</h3>"), Not(HasSubstr("they are not compared"))));
  EXPECT_LT(html.find("Machines side by side"), html.find("<h3>paper</h3>"));
  EXPECT_EQ(html.find("Violated: grtx on ada"), html.rfind("Violated: grtx on ada"));  // once, with its machine
}

// Which design loses most stood above the table, why two screens below it.
TEST_F(SideBySide, WhatBindsADesignStandsInTheRowOfItsMachines) {
  ordered_json document = several();
  for (std::size_t m = 0; m < 2; ++m) {
    document["machines"][m]["binding_bound"]["grtx"] = m == 0 ? "l2_port" : "rt_port";
    document["machines"][m]["designs"]["grtx"]["gpu.bound.fraction"] = {{"value", 0.5}};
  }
  const std::string html = page({document});
  EXPECT_THAT(html,
              testing::ContainsRegex("data-what=\"what binds it:?\">paper: [^;]*L2[^;]*, 50 %; ada: [^;]*, 50 %</td>"));
}

// Two results of one view stood in a table "they are not compared with each other".
TEST_F(SideBySide, RunsOfTwoFilesOnTwoMachinesAreCompared) {
  EXPECT_THAT(page({one("paper", 4000, 1000, 8), one("ada", 200, 100, 142)}),
              AllOf(HasSubstr("Machines side by side"), HasSubstr("20.00×"), Not(HasSubstr("they are not compared"))));
}

TEST_F(SideBySide, OtherViewsAndOtherRoundsAreNotCompared) {
  ordered_json other_view = one("ada", 200, 100, 142), other_k = other_view;
  for (const char* design : {"baseline", "grtx"}) {
    other_view["inputs"][design]["trace.camera_hash"] = "3";
    other_k["inputs"][design]["trace.k"] = "16";
  }
  for (const ordered_json& other : {other_view, other_k}) {
    EXPECT_THAT(page({one("paper", 4000, 1000, 8), other}),
                AllOf(Not(HasSubstr("Machines side by side")), HasSubstr("they are not compared with each other")));
  }
}

ordered_json launched(ordered_json document, double warps) {
  for (ordered_json& machine : document["machines"]) {
    for (auto& [name, design] : machine["designs"].items()) {
      design["gpu.distributor.groups"] = {{"value", warps}, {"unit", ""}, {"description", ""}};
    }
  }
  return document;
}

// At 72 warps for 256 slots walk lost nothing by half the SMs (0.99), at 512 warps 0.59: a chip of notes said why.
TEST_F(SideBySide, ALaunchThatDoesNotFillTheMachinesIsSaidBesideTheRatios) {
  ordered_json document = several();
  document["machines"][1]["config"]["gpu.sms"] = 4;
  const std::string small =
      "this image has 128 warps for 256 slots: too small to compare machines; take --width 128 --height 128 or more";
  const std::string html = page({launched(document, 128)});
  EXPECT_LT(html.find(small), html.find("<h3>paper</h3>"));
  EXPECT_THAT(html, HasSubstr("times as fast as on paper (too few warps)"));
  EXPECT_THAT(page({launched(document, 512)}), AllOf(Not(HasSubstr("too small")), Not(HasSubstr("too few"))));
}

// The size that the line named was refused by the next one, which named none.
TEST_F(SideBySide, ALaunchThatIsMostlyTailIsTooSmallToo) {
  ordered_json document = several();
  document["machines"][1]["config"]["gpu.sms"] = 4;
  for (ordered_json& machine : document["machines"]) {
    for (auto& [name, design] : machine["designs"].items()) {
      design["gpu.distributor.tail_cycles"] = {
          {"value", 0.9 * design["gpu.cycles"]["value"].get<double>()}, {"unit", ""}, {"description", ""}};
    }
  }
  EXPECT_THAT(page({launched(document, 512)}),
              HasSubstr("has 512 warps for 128 slots, and 90 % of the run is tail: too small to compare machines; take "
                        "--width 176 --height 176 or more"));
}

// Which design loses most had to be searched in a column.
TEST_F(SideBySide, ASentenceSaysWhichDesignLosesMost) {
  ordered_json document = several();
  document["machines"][1] = machine("half", 8000, 1250, 4);
  EXPECT_THAT(page({document}), HasSubstr("On half baseline loses most: 0.50 times as fast as on paper; grtx least: "
                                          "0.80 times. "));
  EXPECT_THAT(page({several()}), HasSubstr("On ada grtx gains least: 10.00 times as fast as on paper; baseline most: "
                                           "20.00 times. "));
}

// "On half grtx loses most: 1.00 times" of 0.996.
TEST(LosesMost, ADesignThatLosesNothingWithinTheDigitsShownDoesNotLoseMost) {
  EXPECT_EQ(loses_most_text({{"grtx", 0.996}, {"walk", 1.004}}, "half", "paper"),
            "on half all designs are as fast as on paper");
  EXPECT_EQ(loses_most_text({{"grtx", 0.996}}, "half", "paper"), "on half grtx is as fast as on paper");
  EXPECT_EQ(loses_most_text({{"grtx", 0.996}, {"walk", 1.2}}, "half", "paper"),
            "on half grtx gains least: 1.00 times as fast as on paper; walk most: 1.20 times");
  EXPECT_EQ(loses_most_text({{"grtx", 0.994}, {"walk", 0.996}}, "half", "paper"),
            "on half grtx loses most: 0.99 times as fast as on paper; walk least: 1.00 times");
}

// "dram.bandwidth_gb_s 0.0 | 56.0" read as a machine without DRAM; it has 112.
TEST_F(SideBySide, AKeyThatNobodySetsShowsWhatFollows) {
  ordered_json document = several();
  document["machines"][1]["config"]["dram.bandwidth_gb_s"] = 56.0;
  document["machines"][1]["config"]["dram.timing.faw"] = 20;
  EXPECT_THAT(page({document}),
              AllOf(HasSubstr("<th scope=\"row\">dram.bandwidth_gb_s</th><td>112.0, by dram.mhz</td><td>56.0</td>"),
                    HasSubstr("<th scope=\"row\">dram.timing.faw</th><td>not set</td><td>20</td>")));
}

TEST_F(SideBySide, AMachineThatIsNoObjectIsRefused) {
  ordered_json wrong = several();
  wrong["machines"][1] = 3;
  EXPECT_THROW(page({wrong}), Error);
  wrong["machines"] = ordered_json::array();
  EXPECT_THROW(page({wrong}), Error);
}

}  // namespace
}  // namespace grtx::report
