// SPDX-License-Identifier: Apache-2.0
// The main job on a small generated scene, through the program: synth, trace, check, run, sim twice, errors.
#include <gtest/gtest.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/base/atomic_file.h"
#include "grtx/base/file_lock.h"
#include "paths.h"
#include "shell.h"
#include "temporary_folder.h"

namespace grtx {
namespace {

using test::Outcome;

class RunTest : public testing::Test {
 protected:
  Outcome grtx(const std::string& arguments) { return test::shell(grtx::paths::program() + " " + arguments); }
  void must(const std::string& arguments) {
    const Outcome outcome = grtx(arguments);
    ASSERT_EQ(outcome.code, 0) << arguments << "\n" << outcome.output;
  }
  nlohmann::json json(const std::string& file) { return nlohmann::json::parse(read_file(folder + "/" + file)); }
  std::string scene_arguments() {
    return "--scene " + folder + "/s.ply --cameras " + folder + "/s.cameras.json --view 0 --width 24 --height 16 ";
  }
  std::string config() { return "--config " + grtx::paths::source_dir() + "/configs/small.toml "; }

  /// A text without the line ends that fit it to 80 columns.
  static std::string unwrapped(std::string text) {
    for (std::size_t at = 0; (at = text.find("\n  ", at)) != std::string::npos;) text.replace(at, 3, " ");
    return text;
  }

  const test::TemporaryFolder own_folder;
  const std::string folder = own_folder.path();
};

TEST_F(RunTest, DesignsEndToEnd) {
  must("synth --preset object --count 3000 --seed 7 -o " + folder + "/s.ply --quiet");
  must("run " + scene_arguments() + config() + "--quiet -o " + folder + "/out");
  const nlohmann::json results = json("out/results.json");
  EXPECT_EQ(results.at("schema"), "grtx.run/2");
  EXPECT_TRUE(results.at("images_identical").get<bool>());
  EXPECT_TRUE(results.at("violations").empty());
  const auto stat = [&](const char* design, const char* name) {
    return results.at("designs").at(design).at(name).at("value").get<double>();
  };
  for (const char* design : {"baseline", "sw", "hw", "grtx", "gautracer", "walk"}) {
    EXPECT_EQ(stat(design, "gpu.rt.node_visits"), stat(design, "tracer.visits.total")) << design;
    EXPECT_LE(stat(design, "gpu.rt.node_fetches"), stat(design, "gpu.rt.node_visits")) << design;
    EXPECT_GE(stat(design, "gpu.cycles"), stat(design, "gpu.bound.largest")) << design;
    if (design != std::string("gautracer") && design != std::string("walk")) {  // which blend in another order
      EXPECT_EQ(stat(design, "tracer.blended"), stat("baseline", "tracer.blended")) << design;
    }
    must("trace-check " + folder + "/out/" + design + ".grtx --quiet");
  }
  EXPECT_LT(stat("hw", "tracer.visits.total"), stat("baseline", "tracer.visits.total"));
  EXPECT_LT(stat("grtx", "tracer.visits.total"), stat("sw", "tracer.visits.total"));
  EXPECT_TRUE(std::filesystem::exists(folder + "/out/image.png"));
  EXPECT_EQ(stat("gautracer", "gpu.rt.any_hit.unit.hits"), stat("gautracer", "tracer.any_hit.calls"));
  EXPECT_EQ(stat("gautracer", "gpu.simt.any_hit.calls"), 0);
  EXPECT_EQ(results.at("other_orders").at("gautracer").at("order"), "peak");
  EXPECT_GT(results.at("other_orders").at("gautracer").at("psnr").get<double>(), 15.0);
  EXPECT_EQ(results.at("design_config").at("gautracer").at("rt.any_hit_unit.enabled"), "true");
  EXPECT_EQ(results.at("inputs").at("gautracer").at("trace.k"), "48");
  EXPECT_EQ(results.at("inputs").at("grtx").at("trace.k"), "16");
}

// dB of gautracer and walk stood on stdout alone, and those against the fp64 reference nowhere.
TEST_F(RunTest, EachDesignAndFrameSaysHowFarItsPictureIs) {
  must("synth --preset object --count 600 --seed 7 -o " + folder + "/s.ply --quiet");
  std::string view = scene_arguments();
  view.replace(view.find("--view 0"), 8, "--views 0:1");
  must("run " + view + config() + "--designs baseline,grtx,gautracer,walk --quiet -o " + folder + "/out");
  const nlohmann::json pictures = json("out/results.json").at("pictures");
  ASSERT_EQ(pictures.size(), 4U);
  for (const auto& [design, own] : pictures.items()) {
    EXPECT_EQ(own.at("reference"), "fp64") << design;
    EXPECT_EQ(own.at("reference_pixels"), 24 * 16) << design;  // less than 48 x 48
    ASSERT_EQ(own.at("psnr").size(), 2U) << design;
    ASSERT_EQ(own.at("psnr_reference").size(), 2U) << design;
    for (int frame = 0; frame < 2; ++frame) {
      const bool same_order = design == "baseline" || design == "grtx";
      EXPECT_EQ(own.at("psnr")[frame].is_null(), same_order) << design;
      if (!same_order) {
        EXPECT_LT(own.at("psnr")[frame].get<double>(), 80.0) << design;
      }
      // In its own order a design draws what it should; walk's Gaussians are rounded.
      EXPECT_GT(own.at("psnr_reference")[frame].get<double>(), design == "walk" ? 45.0 : 80.0) << design;
    }
  }
  EXPECT_EQ(pictures.at("gautracer").at("order"), "peak");
  EXPECT_EQ(pictures.at("walk").at("order"), "entry into spheres of quantised Gaussians");
}

// It said "grtx blends by entry into polyhedra: 32.8 dB from grtx": of walk, which is traced first. So was the picture.
TEST_F(RunTest, NoDesignBlendsInAnotherOrderThanItself) {
  must("synth --preset object --count 600 --seed 7 -o " + folder + "/s.ply --quiet");
  const Outcome said =
      grtx("run " + scene_arguments() + config() + "--designs grtx,gautracer,walk -o " + folder + "/out");
  ASSERT_EQ(said.code, 0) << said.output;
  EXPECT_NE(said.output.find("walk blends by entry into spheres of quantised Gaussians: "), std::string::npos);
  EXPECT_EQ(said.output.find("grtx blends by"), std::string::npos) << said.output;
  const nlohmann::json results = json("out/results.json"), &others = results.at("other_orders");
  EXPECT_EQ(others.size(), 2U);
  for (const char* design : {"gautracer", "walk"}) {
    const nlohmann::json& picture = results.at("pictures").at(design);
    EXPECT_EQ(others.at(design).at("order"), picture.at("order")) << design;
    EXPECT_DOUBLE_EQ(others.at(design).at("psnr").get<double>(), picture.at("psnr")[0].get<double>()) << design;
  }
  must("run " + scene_arguments() + config() + "--designs grtx --quiet -o " + folder + "/alone");
  EXPECT_EQ(read_file(folder + "/out/image.png"), read_file(folder + "/alone/image.png"));
}

// "gautracer blends by peak: inf dB from baseline"
TEST_F(RunTest, AnIdenticalPictureIsCalledIdentical) {
  must("synth --preset object --count 1 --seed 3 -o " + folder + "/s.ply --quiet");
  const Outcome said =
      grtx("run " + scene_arguments() + config() + "--designs baseline,gautracer -o " + folder + "/out");
  ASSERT_EQ(said.code, 0) << said.output;
  EXPECT_NE(said.output.find("\ngautracer blends by peak: identical to baseline\n"), std::string::npos) << said.output;
}

// The table did not say that its cycles are of all frames, nor whose L1 hits it has; a picture was that of frame 0.
TEST_F(RunTest, TheTableOfASequenceSaysWhatItsFiguresAreOf) {
  must("synth --preset object --count 600 --seed 7 -o " + folder + "/s.ply --quiet");
  const Outcome said = grtx("run --scene " + folder + "/s.ply --cameras " + folder +
                            "/s.cameras.json --views 0:1 --width 24 --height 16 " + config() +
                            "--designs baseline,walk -o " + folder + "/out");
  ASSERT_EQ(said.code, 0) << said.output;
  EXPECT_NE(said.output.find("\ncycles, visits, fetches, accesses and bytes are of all 2 frames\n"), std::string::npos)
      << said.output;
  EXPECT_NE(said.output.find(" L1 node "), std::string::npos);
  EXPECT_NE(unwrapped(said.output).find(" dB from baseline, worst frame\n"), std::string::npos) << said.output;
  const nlohmann::json results = json("out/results.json");
  const auto psnr = results.at("pictures").at("walk").at("psnr").get<std::vector<double>>();
  EXPECT_EQ(results.at("other_orders").at("walk").at("psnr"), *std::ranges::min_element(psnr));
}

// It said "there are 0.96 hits for each that is processed": those of walk's spheres over those of grtx's polyhedra.
TEST_F(RunTest, HitsAreThoseOfTheDesignsOwnProxy) {
  must("synth --preset flat --count 1500 --seed 3 -o " + folder + "/s.ply --quiet");
  must("run " + scene_arguments() + config() + "--quiet -o " + folder + "/out");
  const nlohmann::json beside = json("out/results.json").at("designs");
  for (const std::string design : {"hw", "grtx", "gautracer", "walk"}) {
    must("run " + scene_arguments() + config() + "--quiet --designs " + design + " -o " + folder + "/alone");
    const nlohmann::json alone = json("alone/results.json").at("designs").at(design);
    for (const char* name : {"tracer.hits", "tracer.hits_behind_end"}) {
      EXPECT_EQ(beside.at(design).at(name), alone.at(name)) << design;
    }
    EXPECT_GE(alone.at("tracer.hits_behind_end").at("value").get<double>(), 1.0) << design;
  }
  EXPECT_NE(beside.at("walk").at("tracer.hits"), beside.at("grtx").at("tracer.hits"));
  EXPECT_NE(beside.at("walk").at("tracer.hits"), beside.at("gautracer").at("tracer.hits"));
}

// A run took one machine; two results in one report were "not compared with each other".
TEST_F(RunTest, MachinesStandSideBySideAndShareTraces) {
  must("synth --preset object --count 300 --seed 7 -o " + folder + "/s.ply --quiet");
  write_file(folder + "/half.toml", "include = 'paper'\n[gpu]\nsms = 4\n");
  const std::string view = scene_arguments() + "--set gpu.resident_warps=4 --designs baseline,grtx,walk --quiet ";
  must("run " + view + "--machine paper," + folder + "/half.toml,paper-lean -o " + folder + "/out");
  const nlohmann::json results = json("out/results.json");
  ASSERT_EQ(results.at("machines").size(), 3U);
  EXPECT_FALSE(results.contains("designs"));
  EXPECT_EQ(results.at("pictures").size(), 3U);
  EXPECT_TRUE(results.at("images_identical").get<bool>());
  const nlohmann::json& between = results.at("between_machines");
  EXPECT_EQ(between.at("over"), "paper, changed");
  EXPECT_EQ(between.at("keys").at("gpu.sms"), (nlohmann::json{8, 4, 8}));
  EXPECT_EQ(between.at("keys").at("tracer.checkpoint_bins"), (nlohmann::json{"0", "0", "4"}));
  EXPECT_FALSE(between.at("keys").contains("gpu.resident_warps"));  // set for all
  const auto time = [&](std::size_t machine, const char* design) {
    return results.at("machines")[machine].at("designs").at(design).at("gpu.time_us").at("value").get<double>();
  };
  EXPECT_DOUBLE_EQ(between.at("speedup").at("half, changed").at("grtx").get<double>(),
                   time(0, "grtx") / time(1, "grtx"));
  // Each is what it is alone, and a trace that several machines ask for is made once.
  std::size_t place = 0;
  for (const std::string machine : {"paper", "half", "paper-lean"}) {
    const std::string name = machine == "half" ? folder + "/half.toml" : machine;
    must("run " + view + "--machine " + name + " -o " + folder + "/alone");
    const nlohmann::json alone = json("alone/results.json"), &beside = results.at("machines")[place++];
    EXPECT_EQ(beside.at("machine"), machine + ", changed");
    for (const char* design : {"baseline", "grtx", "walk"}) {
      EXPECT_EQ(beside.at("designs").at(design).at("gpu.cycles"), alone.at("designs").at(design).at("gpu.cycles"));
      EXPECT_EQ(beside.at("speedup"), alone.at("speedup"));
    }
  }
  const auto has = [&](const std::string& file) { return std::filesystem::exists(folder + "/out/" + file); };
  EXPECT_TRUE(has("grtx.grtx") && has("grtx.paper-lean.grtx") && has("baseline.grtx"));
  EXPECT_FALSE(has("grtx.half.grtx") || has("baseline.paper-lean.grtx") || has("walk.paper-lean.grtx"));
  const std::string page = read_file(folder + "/out/report.html");
  EXPECT_NE(page.find("<h3>Machines side by side</h3>"), std::string::npos);
  EXPECT_EQ(page.find("they are not compared with each other"), std::string::npos);
  // A machine's name or its file; and all designs and machines in one table, which had no command.
  must("cost --stats " + folder + "/out/results.json --design grtx --machine " + folder + "/half.toml --quiet");
  const Outcome all = grtx("cost --stats " + folder + "/out/results.json --csv " + folder + "/all.csv");
  EXPECT_NE(all.output.find("energy on half, changed, uJ"), std::string::npos) << all.output;
  const std::string table = read_file(folder + "/all.csv");
  for (const char* row :
       {"machine,design,part,", "\n\"half, changed\",walk,rt.", "\n\"paper, changed\",baseline,dram,"}) {
    EXPECT_NE(table.find(row), std::string::npos) << row;
  }
  const std::string price = "cost --stats " + folder + "/out/results.json --design grtx --machine half ";
  must(price + "--csv " + folder + "/energy.csv");
  EXPECT_NE(read_file(folder + "/energy.csv").find("\nrt.ray_box,"), std::string::npos);
  const Outcome energy = grtx(price + "--json");
  EXPECT_EQ(nlohmann::json::parse(energy.output).at("frame_nanojoules").at("central"),
            results.at("machines")[1].at("designs").at("grtx").at("gpu.energy_nj").at("value"));
  // Traces of machines that are not compared now go.
  must("run " + view + "--machine paper -o " + folder + "/out");
  EXPECT_TRUE(has("grtx.grtx"));
  EXPECT_FALSE(has("grtx.paper-lean.grtx"));
}

// At 12 warps for 32 slots the text ranked machines without a word, and "dram.bandwidth_gb_s 0.0" read as no DRAM.
TEST_F(RunTest, TheTextOfMachinesSaysThatTheImageIsTooSmallWhoLosesMostAndWhatAKeyComesTo) {
  must("synth --preset object --count 300 --seed 7 -o " + folder + "/s.ply --quiet");
  write_file(folder + "/half.toml", "include = 'paper'\n[gpu]\nsms = 4\n[dram]\nbandwidth_gb_s = 56.0\n");
  const Outcome run = grtx("run " + scene_arguments() + "--set gpu.resident_warps=4 --designs baseline,walk " +
                           "--machine paper," + folder + "/half.toml -o " + folder + "/out");
  ASSERT_EQ(run.code, 0) << run.output;
  for (const char* text :
       {"mind: this image has 12 warps for 32 slots: too small to compare machines; take --width 56 "
        "--height 40 or more",
        "too small to compare designs", "times in us, in brackets", "\non half ", "112.0, by dram.mhz"}) {
    EXPECT_NE(unwrapped(run.output).find(text), std::string::npos) << text << "\n" << run.output;
  }
  const Outcome help = grtx("run --help");
  EXPECT_NE(help.output.find("=each design's own (docs/guide/designs.md)"), std::string::npos) << help.output;
  EXPECT_EQ(help.output.find("--k UINT:1 to 2048=8"), std::string::npos);
}

// It was "speed-up over gautracer", and nothing behind it.
TEST_F(RunTest, ALineSaysWhatSpeedUpsAreOver) {
  must("synth --preset object --count 300 --seed 7 -o " + folder + "/s.ply --quiet");
  const std::string designs = "run " + scene_arguments() + config() + "--designs gautracer,walk -o " + folder + "/out ";
  for (const auto& [k, line] : {std::pair("", "\nspeed-ups are over gautracer at k = 48; walk at 64"),
                                std::pair("--k 16", "\nspeed-ups are over gautracer\n")}) {
    const Outcome run = grtx(designs + k);
    ASSERT_EQ(run.code, 0) << run.output;
    EXPECT_NE(run.output.find(line), std::string::npos) << run.output;
    EXPECT_EQ(run.output.find("\nspeed-up over gautracer\n"), std::string::npos) << run.output;
  }
}

// Windows have no statistics of caches and DRAM: both texts ended with an internal error.
TEST_F(RunTest, TextsOfWindowsShowADashAndTheInterval) {
  must("synth --preset object --count 40 --seed 7 -o " + folder + "/s.ply --quiet");
  std::string view = scene_arguments();
  view.replace(view.find("--width 24 --height 16"), 22, "--width 416 --height 416");
  const std::string small = "--machine paper --set gpu.sms=1 --set gpu.resident_warps=4 --mode windows ";
  const Outcome run = grtx("run " + view + small + "--designs baseline,grtx -o " + folder + "/out");
  ASSERT_EQ(run.code, 0) << run.output;
  EXPECT_NE(unwrapped(run.output).find("95 % intervals of the speed-ups: grtx "), std::string::npos) << run.output;
  EXPECT_NE(run.output.find(" -\n"), std::string::npos) << run.output;  // DRAM MB
  // Of cycles there was no interval, and of the dashes no word.
  EXPECT_NE(unwrapped(run.output).find("95 % intervals of the cycles: baseline "), std::string::npos) << run.output;
  EXPECT_NE(run.output.find("\n-: latency, hit rates and traffic are counted in cycle mode alone\n"),
            std::string::npos);
  const Outcome sim = grtx("sim " + folder + "/out/grtx.grtx " + small);
  ASSERT_EQ(sim.code, 0) << sim.output;
  EXPECT_NE(sim.output.find("; 95 % interval "), std::string::npos) << sim.output;
  EXPECT_NE(unwrapped(sim.output).find("L2 - %"), std::string::npos) << sim.output;
}

TEST_F(RunTest, MachinesOfARunHaveNamesOfTheirOwnAndDrawOnePicture) {
  must("synth --preset object --count 300 --seed 7 -o " + folder + "/s.ply --quiet");
  write_file(folder + "/early.toml", "include = 'paper'\n[tracer]\nert = 0.1\n");
  const auto refused = [&](const std::string& machines) {
    const Outcome outcome = grtx("run " + scene_arguments() + "--quiet -o " + folder + "/out --machine " + machines);
    EXPECT_EQ(outcome.code, 2) << machines;
    EXPECT_FALSE(std::filesystem::exists(folder + "/out"));
    return outcome.output;
  };
  EXPECT_NE(refused("paper,paper").find("--machine: paper: is there twice"), std::string::npos);
  EXPECT_NE(refused("paper," + folder + "/early.toml").find("early: has ert = 0.1, paper has 0.001"),
            std::string::npos);
  EXPECT_NE(refused("paper,adda").find("adda"), std::string::npos);
}

// --tracing single failed the whole run: grtx and walk have rounds alone.
TEST_F(RunTest, ADesignThatRefusesAnOptionIsLeftOutAndSaysWhy) {
  must("synth --preset object --count 300 --seed 7 -o " + folder + "/s.ply --quiet");
  const std::string run = "run " + scene_arguments() + config() + "--tracing single --quiet -o " + folder + "/out ";
  const Outcome outcome = grtx(run);
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  const nlohmann::json results = json("out/results.json");
  EXPECT_EQ(results.at("designs").size(), 2U);  // baseline and sw
  EXPECT_EQ(results.at("left_out").size(), 4U);
  for (const auto& [name, why] : results.at("left_out").items()) {
    const std::string line = "grtx: run: " + name + " is left out: " + why.get<std::string>() + "\n";
    EXPECT_NE(outcome.output.find(line), std::string::npos) << outcome.output;
  }
  EXPECT_NE(read_file(folder + "/out/report.html").find("walk is left out: --"), std::string::npos);
  EXPECT_EQ(grtx(run + "--designs baseline,walk").code, 2);  // named, it is what was asked for
}

// Only a single simulation had its course on a page.
TEST_F(RunTest, EachDesignHasItsOccupancyOverTime) {
  must("synth --preset object --count 300 --seed 7 -o " + folder + "/s.ply --quiet");
  must("run " + scene_arguments() + config() + "--designs baseline,walk --quiet -o " + folder + "/out");
  const nlohmann::json results = json("out/results.json");
  for (const char* design : {"baseline", "walk"}) {
    const nlohmann::json& course = results.at("over_time").at(design);
    const nlohmann::json& ends = course.at("end_of_interval").at("values");
    EXPECT_EQ(ends.back(), results.at("designs").at(design).at("gpu.cycles").at("value")) << design;
    double integral = 0.0, begin = 0.0;
    for (std::size_t i = 0; i < ends.size(); begin = ends[i++].get<double>()) {
      integral += course.at("rt.occupancy").at("values")[i].get<double>() * (ends[i].get<double>() - begin);
    }
    const double whole = results.at("designs").at(design).at("gpu.rt.occupancy").at("value").get<double>();
    EXPECT_NEAR(integral / begin, whole, 1e-6 * whole) << design;
  }
  const std::string page = read_file(folder + "/out/report.html");
  EXPECT_NE(page.find("mean warps in the warp buffer of an RT unit, warps"), std::string::npos);
  EXPECT_NE(page.find("of the design's cycles"), std::string::npos);
}

// What a speed-up is made of stood nowhere.
TEST_F(RunTest, AWaterfallMultipliesToEachSpeedUpAndLevelsOfLatencyAreOnThePage) {
  must("synth --preset object --count 300 --seed 7 -o " + folder + "/s.ply --quiet");
  must("run " + scene_arguments() + config() + "--designs baseline,grtx,walk --latency --quiet -o " + folder + "/out");
  const nlohmann::json results = json("out/results.json");
  for (const auto& [name, terms] : results.at("waterfall").items()) {
    double product = 1.0;
    for (const nlohmann::json& term : terms) product *= term.at("speedup").get<double>();
    EXPECT_NEAR(product, results.at("speedup").at(name).get<double>(), 1e-9 * product) << name;
  }
  EXPECT_EQ(results.at("waterfall").size(), 2U);
  EXPECT_GT(results.at("designs").at("walk").at("gpu.latency.nodes.whole").at("value").get<double>(), 0.0);
  const std::string page = read_file(folder + "/out/report.html");
  for (const char* part : {"speed-up over baseline, the terms", "memory: DRAM", "Reads of 32 B: cycles"}) {
    EXPECT_NE(page.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(grtx("run " + scene_arguments() + config() + "--latency --mode windows -o " + folder + "/no").code, 2);
}

TEST_F(RunTest, WhatYouSetADesignLeavesAsItIs) {
  must("synth --preset object --count 600 --seed 7 -o " + folder + "/s.ply --quiet");
  must("run " + scene_arguments() + config() +
       "--sort-key peak --k 4 --set rt.any_hit_unit.latency=5 --set simt.payload_registers=0 --quiet -o " + folder +
       "/out");
  const nlohmann::json results = json("out/results.json");
  EXPECT_TRUE(results.at("images_identical").get<bool>());
  EXPECT_EQ(results.at("other_orders").size(), 1U);  // all are one image but walk's, of rounded Gaussians
  EXPECT_EQ(results.at("inputs").at("gautracer").at("trace.k"), "4");
  EXPECT_FALSE(results.at("design_config").at("gautracer").contains("simt.payload_registers"));
}

// Heaps of 48 hits in registers for 16.
TEST_F(RunTest, RegistersOfHeapsFollowK) {
  must("synth --preset object --count 600 --seed 7 -o " + folder + "/s.ply --quiet");
  must("run " + scene_arguments() + config() + "--designs baseline,gautracer --k 48 --quiet -o " + folder + "/out");
  EXPECT_EQ(json("out/results.json").at("design_config").at("gautracer").at("simt.payload_registers"), "144");
  must("sim " + folder + "/out/gautracer.grtx --design gautracer " + config() + "--quiet --stats " + folder +
       "/n.json");
  const nlohmann::json statistics = json("n.json");
  EXPECT_EQ(statistics.at("config").at("simt.payload_registers"), 144);
  EXPECT_EQ(statistics.at("stats").at("gpu.cycles"),
            json("out/results.json").at("designs").at("gautracer").at("gpu.cycles"));
  for (const nlohmann::json& note : statistics.at("notes")) {
    EXPECT_NE(note.at("id"), "heap-registers");
    EXPECT_NE(note.at("id"), "design-keys");
  }
}

TEST_F(RunTest, DesignsAreChosenByName) {
  must("synth --preset object --count 300 --seed 7 -o " + folder + "/s.ply --quiet");
  const std::string run = "run " + scene_arguments() + config() + "--quiet -o " + folder + "/out --designs ";
  must(run + "gautracer,grtx");
  const nlohmann::json results = json("out/results.json");
  EXPECT_EQ(results.at("designs").size(), 2U);
  EXPECT_EQ(results.at("speedup_over"), "grtx");
  EXPECT_TRUE(results.at("speedup").contains("gautracer"));
  const Outcome refused = grtx(run + "gautracr");
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.output.find("gautracer"), std::string::npos) << refused.output;
}

// A run of one view left image.png, and the report of a sequence of another scene showed it.
TEST_F(RunTest, PicturesOfAnEarlierRunGo) {
  must("synth --preset object --count 300 --seed 7 -o " + folder + "/s.ply --quiet");
  must("run " + scene_arguments() + "--set gpu.sms=1 --quiet -o " + folder + "/out");
  write_file(folder + "/out/image_7.png", "a picture of mine");
  must("synth --preset hall --count 300 --seed 8 -o " + folder + "/h.ply --quiet");
  must("run --scene " + folder + "/h.ply --cameras " + folder +
       "/h.cameras.json --views 0:1 --width 24 --height 16 --set gpu.sms=1 --mode cycle --quiet -o " + folder + "/out");
  EXPECT_FALSE(std::filesystem::exists(folder + "/out/image.png"));
  EXPECT_EQ(read_file(folder + "/out/image_7.png"), "a picture of mine");
  const nlohmann::json images = json("out/results.json").at("images");
  ASSERT_EQ(images.size(), 2u);
  EXPECT_EQ(images[0].at("file"), "image_0.png");
  const std::string page = read_file(folder + "/out/report.html");
  EXPECT_NE(page.find("<img src=\"data:image/png;base64,"), std::string::npos);
}

// A run of one design left the traces of the others beside its results, and they were of another scene.
TEST_F(RunTest, TracesOfAnEarlierRunGo) {
  must("synth --preset object --count 300 --seed 7 -o " + folder + "/s.ply --quiet");
  const std::string run =
      "run " + scene_arguments() + "--set gpu.sms=1 --mode cycle --quiet -o " + folder + "/out --designs ";
  must(run + "baseline,sw,hw,grtx");
  write_file(folder + "/out/mine.grtx", "a file of mine");
  std::filesystem::copy_file(folder + "/out/grtx.grtx", folder + "/out/a_copy.grtx");
  std::filesystem::copy_file(folder + "/out/sw.grtx", folder + "/out/hw.grtx",  // no longer that of the earlier run
                             std::filesystem::copy_options::overwrite_existing);
  write_file(folder + "/out/walk.grtx", "of mine, too");
  must(run + "baseline");
  const auto is_there = [&](const char* name) { return std::filesystem::exists(folder + "/out/" + name); };
  EXPECT_TRUE(is_there("baseline.grtx"));
  EXPECT_FALSE(is_there("sw.grtx"));
  EXPECT_FALSE(is_there("grtx.grtx"));
  EXPECT_TRUE(is_there("a_copy.grtx"));
  EXPECT_TRUE(is_there("hw.grtx"));
  EXPECT_EQ(read_file(folder + "/out/mine.grtx"), "a file of mine");
  EXPECT_EQ(read_file(folder + "/out/walk.grtx"), "of mine, too");
}

TEST_F(RunTest, ASecondRunIntoAFolderThatOneFillsIsRefused) {
  must("synth --preset object --count 300 --seed 7 -o " + folder + "/s.ply --quiet");
  std::filesystem::create_directories(folder + "/out");
  const std::string run = "run " + scene_arguments() + config() + "--quiet -o " + folder + "/out";
  {
    const FileLock other(folder + "/out/run.lock", "out", "");  // as another process holds it
    const Outcome refused = grtx(run);
    EXPECT_EQ(refused.code, 2);
    EXPECT_EQ(refused.output, "grtx: " + folder + "/out: another grtx run is filling it\n");
    EXPECT_FALSE(std::filesystem::exists(folder + "/out/results.json"));
  }
  write_file(folder + "/out/run.lock", "");  // a killed run leaves it
  must(run);
  EXPECT_FALSE(std::filesystem::exists(folder + "/out/run.lock"));
  const nlohmann::json inputs = json("out/results.json").at("inputs");
  for (const char* design : {"baseline", "sw", "hw", "grtx"}) {
    EXPECT_EQ(inputs.at(design).at("trace.files_hash"), inputs.at("grtx").at("trace.files_hash"));
    EXPECT_NE(inputs.at(design).at("trace.files").get<std::string>().find("s.cameras.json "), std::string::npos);
  }
}

TEST_F(RunTest, SecondaryRaysEndToEnd) {
  must("synth --preset object --count 2000 --seed 7 -o " + folder + "/s.ply --quiet");
  must("run " + scene_arguments() + config() + "--secondary both --secondary-seed 2 --quiet -o " + folder + "/out");
  const nlohmann::json results = json("out/results.json");
  EXPECT_TRUE(results.at("images_identical").get<bool>());
  EXPECT_TRUE(results.at("violations").empty());
  const auto stat = [&](const char* design, const char* name) {
    return results.at("designs").at(design).at(name).at("value").get<double>();
  };
  for (const char* design : {"baseline", "sw", "hw", "grtx"}) {
    EXPECT_GT(stat(design, "tracer.secondary.glass_rays"), 0.0);
    EXPECT_GT(stat(design, "tracer.secondary.mirror_rays"), 0.0);
    EXPECT_EQ(stat(design, "tracer.rays"), 24.0 * 16.0 + stat(design, "tracer.secondary.rays"));
    EXPECT_EQ(stat(design, "gpu.rt.node_visits"), stat(design, "tracer.visits.total")) << design;
    EXPECT_GT(stat(design, "gpu.rays.secondary_cycles"), 0.0);
    EXPECT_EQ(stat(design, "gpu.rays.primary_cycles") + stat(design, "gpu.rays.secondary_cycles"),
              stat(design, "gpu.cycles"));
    must("trace-check " + folder + "/out/" + design + ".grtx --quiet");
  }
  EXPECT_GT(results.at("speedup_secondary").at("grtx").get<double>(), 0.0);
  must("reference " + scene_arguments() + "--secondary both --secondary-seed 2 --quiet -o " + folder + "/r.pfm");
  must("trace " + scene_arguments() + "--secondary both --secondary-seed 2 --no-trace --quiet --image " + folder +
       "/i.pfm");
  must("compare " + folder + "/i.pfm " + folder + "/r.pfm --min-psnr 60");
  for (const char* bad : {"--glass 0,0,0,1", "--secondary glass --glass 0,0,0,-1", "--secondary mirror --mirror 1,2,3",
                          "--secondary glas", "--secondary both --glass 0,0,0,1 --mirror 0,0,0.5,0,0,1,2,2"}) {
    EXPECT_EQ(grtx("trace " + scene_arguments() + "--no-trace --quiet " + bad).code, 2) << bad;
  }
}

TEST_F(RunTest, CachesStayWarmFromFrameToFrame) {
  must("synth --preset object --count 1000 --seed 7 -o " + folder + "/s.ply --quiet");
  nlohmann::json cameras = json("s.cameras.json");
  cameras = {cameras.at(0), cameras.at(0), cameras.at(1)};  // the second frame sees what the first has left
  write_file(folder + "/c.json", cameras.dump());
  const std::string scene = "--scene " + folder + "/s.ply --cameras " + folder + "/c.json --width 16 --height 16 ";
  const std::string roomy = config() + "--set l2.bytes=16777216 ";  // holds the scene and all private data
  must("run " + scene + roomy + "--view 0 --quiet -o " + folder + "/one");
  const nlohmann::json one = json("one/results.json").at("designs");
  for (const unsigned frames : {2U, 3U}) {
    const bool cycle = frames == 2;
    must("run " + scene + roomy + (cycle ? "--mode cycle --views 0:1" : "--views 0:2") + " --quiet -o " + folder +
         "/out");
    const nlohmann::json results = json("out/results.json");
    EXPECT_TRUE(results.at("images_identical").get<bool>());
    EXPECT_TRUE(results.at("violations").empty());
    for (const char* design : {"baseline", "sw", "hw", "grtx"}) {
      const nlohmann::json& stats = results.at("designs").at(design);
      const auto value = [](const nlohmann::json& of, const char* name) {
        return of.at(name).at("value").get<double>();
      };
      const nlohmann::json& cycles = results.at("frames").at("cycles").at(design);
      ASSERT_EQ(cycles.size(), frames);
      double sum = 0.0;
      for (const auto& frame : cycles) sum += frame.get<double>();
      EXPECT_EQ(sum, value(stats, "gpu.cycles"));
      EXPECT_EQ(value(stats, "tracer.rays"), frames * 16 * 16);
      EXPECT_EQ(value(stats, "gpu.rt.node_visits"), value(stats, "tracer.visits.total"));
      must("trace-check " + folder + "/out/" + design + ".grtx --quiet");
      if (!cycle) continue;
      // The second frame reads next to nothing from DRAM, and the first ran as if it were alone.
      EXPECT_LT(value(stats, "gpu.dram.reads"), 1.02 * value(one.at(design), "gpu.dram.reads")) << design;
      EXPECT_GT(value(one.at(design), "gpu.dram.reads"), 1000.0);
      EXPECT_EQ(cycles[0].get<double>(), value(one.at(design), "gpu.cycles")) << design;
    }
  }
  must("compare " + folder + "/out/image_0.png " + folder + "/one/image.png --min-psnr inf");
  must("compare " + folder + "/out/image_1.png " + folder + "/one/image.png --min-psnr inf");
  EXPECT_EQ(grtx("compare " + folder + "/out/image_2.png " + folder + "/one/image.png --min-psnr 60").code, 1);
  for (const char* bad :
       {"--views 0:3", "--views 2:1", "--views 1", "--views 0:1 --view 0", "--views 0:1 --mode windows"}) {
    EXPECT_EQ(grtx("run " + scene + config() + bad + " --quiet -o " + folder + "/bad").code, 2) << bad;
  }
  EXPECT_EQ(grtx("sim " + folder + "/out/sw.grtx " + config() + "--mode windows --quiet").code, 2);
}

TEST_F(RunTest, SeveralObjectsAreTracedAndSimulated) {
  must("synth --preset object --count 1500 --seed 7 -o " + folder + "/s.ply --quiet");
  write_file(folder + "/objects.json",
             R"([{"file": "s.ply"}, {"file": "s.ply", "translate": [0.8, 0.1, 0.3], "scale": 0.5}])");
  const std::string scene = "--scene " + folder + "/objects.json --cameras " + folder +
                            "/s.cameras.json --view 0 --width 24 --height 16 --quiet ";
  must("trace " + scene + "--accel tlas-tri20 --no-trace --image " + folder + "/i.pfm --stats " + folder + "/s.json");
  EXPECT_EQ(json("s.json").at("stats").at("accel.objects").at("value"), 2);
  EXPECT_EQ(json("s.json").at("stats").at("accel.gaussians").at("value"), 3000);
  must("reference " + scene + "-o " + folder + "/r.pfm");
  must("compare " + folder + "/i.pfm " + folder + "/r.pfm --min-psnr 60");
  for (const std::string& refused : {"trace " + scene + "--accel tri20 -o " + folder + "/t.grtx",
                                     "trace " + scene + "--accel tlas-tri20 -o " + folder + "/t.grtx --secondary both",
                                     "run " + scene + "--secondary both -o " + folder + "/out"}) {
    const Outcome outcome = grtx(refused);
    EXPECT_EQ(outcome.code, 2) << refused;
    EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
  }
  EXPECT_FALSE(std::filesystem::exists(folder + "/t.grtx"));

  must("run " + scene + config() + "-o " + folder + "/out");
  const nlohmann::json results = json("out/results.json");
  EXPECT_EQ(results.at("speedup_over"), "sw");
  EXPECT_TRUE(results.at("images_identical").get<bool>());
  EXPECT_TRUE(results.at("violations").empty());
  ASSERT_EQ(results.at("designs").size(), 2u);
  const auto stat = [&](const char* design, const char* name) {
    return results.at("designs").at(design).at(name).at("value").get<double>();
  };
  for (const char* design : {"sw", "grtx"}) {
    EXPECT_EQ(stat(design, "gpu.rt.node_visits"), stat(design, "tracer.visits.total")) << design;
    EXPECT_EQ(stat(design, "accel.update.bytes"), 64 + 64 + 2 * 128) << design;
    must("trace-check " + folder + "/out/" + design + ".grtx --quiet");
  }
  EXPECT_LT(stat("grtx", "tracer.visits.total"), stat("sw", "tracer.visits.total"));
  EXPECT_EQ(results.at("speedup").at("grtx").get<double>(), stat("sw", "gpu.cycles") / stat("grtx", "gpu.cycles"));
  EXPECT_EQ(results.at("pictures").at("grtx").at("reference"), "tracer");  // which is at full precision itself
  EXPECT_TRUE(results.at("pictures").at("grtx").at("psnr_reference")[0].is_null());
  const std::string report = read_file(folder + "/out/report.html");
  EXPECT_NE(report.find("speed-up"), std::string::npos);
  // Flattened it is a scene like any other, of nearly the same image.
  must("run " + scene + config() + "--flatten -o " + folder + "/flat");
  EXPECT_EQ(json("flat/results.json").at("designs").size(), 6u);
  must("compare " + folder + "/flat/image.png " + folder + "/out/image.png --min-psnr 45");
  // Any size of an entry names both leaves.
  for (const char* bytes : {"8", "16", "28"}) {
    must("sim " + folder + "/out/grtx.grtx " + config() + "--quiet --set rt.checkpoint.entry_bytes=" + bytes);
  }
  const Outcome dump = grtx("trace-dump " + folder + "/out/grtx.grtx");
  EXPECT_NE(dump.output.find(" of the scene transform only"), std::string::npos);
}

// Whichever simulation ends first makes room for the next; the longest is begun first.
TEST_F(RunTest, ResultsDoNotDependOnHowManySimulationsRunAtOnce) {
  must("synth --preset object --count 1500 --seed 7 -o " + folder + "/s.ply --quiet");
  std::vector<std::string> tables, documents;
  for (const char* jobs : {"1", "2", "6"}) {
    const Outcome run =
        grtx("run " + scene_arguments() + config() + "--designs baseline,sw,hw,grtx,gautracer,walk --mode cycle -o " +
             folder + "/out --jobs " + jobs);
    ASSERT_EQ(run.code, 0) << run.output;
    ASSERT_NE(run.output.find("machine: "), std::string::npos);
    tables.push_back(run.output.substr(run.output.find("machine: ")));  // before it: progress, by the clock
    auto results = nlohmann::ordered_json::parse(read_file(folder + "/out/results.json"));
    for (auto& design : results.at("designs")) {
      std::vector<std::string> of_host;
      for (const auto& [name, statistic] : design.items()) {
        if (name.starts_with("host.") || name.find("second") != name.npos) of_host.push_back(name);
      }
      for (const std::string& name : of_host) design.erase(name);
      EXPECT_GT(design.size(), 100U);
    }
    documents.push_back(results.dump());
  }
  for (const std::size_t i : {1U, 2U}) {
    EXPECT_EQ(documents[0], documents[i]);
    EXPECT_EQ(tables[0], tables[i]);
  }
}

// It was opened 12 times: three times by each of those who asked for the machine.
TEST_F(RunTest, AMachineFileIsReadOnce) {
  must("synth --preset object --count 300 --seed 7 -o " + folder + "/s.ply --quiet");
  const std::string file = own_folder.write("own.toml", "[gpu]\nsms = 1\n");
  const int watch = ::inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
  // Two equal events in a row would be one: between two that open lies one that closes.
  ASSERT_GE(::inotify_add_watch(watch, file.c_str(), IN_OPEN | IN_CLOSE_NOWRITE), 0);
  must("run " + scene_arguments() + "--machine " + file +
       " --set rt.warp_buffer.entries=4 --designs sw,grtx --mode cycle --quiet -o " + folder + "/out");
  std::array<inotify_event, 64> events{};  // a watched file has no name in them
  const ssize_t bytes = ::read(watch, events.data(), sizeof events);
  ::close(watch);
  ASSERT_GT(bytes, 0);
  const auto opened = std::count_if(events.begin(), events.begin() + bytes / static_cast<ssize_t>(sizeof events[0]),
                                    [](const inotify_event& event) { return (event.mask & IN_OPEN) != 0; });
  EXPECT_EQ(opened, 1);
  EXPECT_EQ(json("out/results.json").at("machine"), "own, changed");
}

TEST_F(RunTest, SameSimulationTwiceGivesTheSameStatistics) {
  must("synth --preset object --count 2000 --seed 9 -o " + folder + "/s.ply --quiet");
  must("trace " + scene_arguments() + "--accel tlas-tri20 --checkpoint on --quiet -o " + folder + "/t.grtx");
  for (const char* name : {"a", "b"}) {
    must("sim " + folder + "/t.grtx " + config() + "--quiet --stats " + folder + "/" + name + ".json");
  }
  nlohmann::json a = json("a.json"), b = json("b.json");
  for (nlohmann::json* document : {&a, &b}) {
    nlohmann::json& stats = document->at("stats");
    for (auto it = stats.begin(); it != stats.end();) {
      it = it.key().rfind("host.", 0) == 0 ? stats.erase(it) : std::next(it);
    }
    EXPECT_GT(stats.size(), 50u);
  }
  EXPECT_EQ(a.dump(), b.dump());
}

TEST_F(RunTest, TracesAndImagesDoNotDependOnThreads) {
  must("synth --preset flat --count 3000 --seed 3 -o " + folder + "/s.ply --quiet");
  for (const char* threads : {"1", "2", "7"}) {
    must("trace " + scene_arguments() + "--accel tri20 --checkpoint on --quiet --threads " + threads + " -o " + folder +
         "/t" + threads + ".grtx --image " + folder + "/i" + threads + ".pfm");
  }
  for (const char* threads : {"2", "7"}) {
    EXPECT_EQ(read_file(folder + "/t1.grtx"), read_file(folder + "/t" + threads + ".grtx"));
    EXPECT_EQ(read_file(folder + "/i1.pfm"), read_file(folder + "/i" + threads + ".pfm"));
  }
}

TEST_F(RunTest, TracerAgreesWithTheReferenceThroughTheProgram) {
  must("synth --preset object --count 2000 --seed 5 -o " + folder + "/s.ply --quiet");
  must("trace " + scene_arguments() + "--accel tri20 --no-trace --quiet --image " + folder + "/i.pfm");
  must("reference " + scene_arguments() + "--accel tri20 --quiet -o " + folder + "/r.pfm");
  must("compare " + folder + "/i.pfm " + folder + "/r.pfm --min-psnr 60");
  EXPECT_EQ(grtx("compare " + folder + "/i.pfm " + folder + "/r.pfm --min-psnr 1000").code, 1);
}

}  // namespace
}  // namespace grtx
