// SPDX-License-Identifier: Apache-2.0
// What the page of a run says beside a speed-up: whose picture it is, the k of each design, what binds it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "grtx/report/page/charts.h"
#include "grtx/report/page/report.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "temporary_folder.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

ordered_json count(double value) { return {{"value", value}, {"unit", ""}, {"description", ""}}; }

/// results.json of baseline and walk, which is four times as fast.
ordered_json results() {
  ordered_json document = {{"schema", "grtx.run/1"}, {"version", "1"}, {"model_version", 8}, {"machine", "paper"}};
  document["config"] = sim::config_json(sim::load_config("", {}));
  const auto add = [&](const std::string& design, double cycles, const std::string& accel, const std::string& k) {
    document["designs"][design] = {{"gpu.cycles", count(cycles)},
                                   {"gpu.rt.node_fetches", count(cycles == 4000 ? 112000 : 1000)},
                                   {"gpu.bound.fraction", count(0.27)},
                                   {"gpu.rt.warp_latency_max", count(cycles == 4000 ? 400 : 830)}};
    document["inputs"][design] = {{"trace.scene", "hall.ply"},
                                  {"trace.camera", "0"},
                                  {"accel", accel},
                                  {"checkpoint", "off"},
                                  {"k", k},
                                  {"width", "64"},
                                  {"height", "64"},
                                  {"mode", "cycle"}};
    document["binding_bound"][design] = "l2_port";
  };
  add("baseline", 4000, "tri20", "8");
  add("walk", 1000, "ellipsoid", "64");
  document["speedup"] = {{"walk", 4.0}};
  document["images_identical"] = true;
  document["pictures"]["baseline"] = {{"order", "entry into polyhedra"},
                                      {"reference", "fp64"},
                                      {"reference_pixels", 2304},
                                      {"psnr", {nullptr, nullptr}},
                                      {"psnr_reference", {110.26, 112.0}}};
  document["pictures"]["walk"] = {{"order", "entry into spheres"},
                                  {"reference", "tracer"},
                                  {"reference_pixels", 4096},
                                  {"psnr", {36.04, 29.12}},
                                  {"psnr_reference", {nullptr, 82.3}}};
  document["frames"] = {{"views", "0:2"}, {"speedup", {{"walk", {4.5, 3.5}}}}};
  return document;
}

class RunPictures : public testing::Test {
 protected:
  std::string page(const ordered_json& document) {
    folder_.write("results.json", document.dump());
    ReportOptions options;
    options.inputs = {folder_.path("results.json")};
    const std::string whole = report_page(options);
    const std::size_t begin = whole.find("<main");
    return whole.substr(begin, whole.find("</main>") - begin);
  }
  const grtx::test::TemporaryFolder folder_;
};

// "bit-identical" stood alone where walk's picture was 36.0 dB from the baseline's.
TEST_F(RunPictures, AWinnerThatDrawsAnotherPictureIsCalledSo) {
  const std::string html = page(results());
  EXPECT_THAT(html, AllOf(HasSubstr("draws another picture, 29.1 dB to 36.0 dB from that of baseline"),
                          HasSubstr(">29.1 dB to 36.0 dB</td>"), HasSubstr(">110.3 dB to 112.0 dB</td>"),
                          HasSubstr(">82.3 dB to identical</td>"),
                          HasSubstr("The reference is the fp64 brute force, on 2,304 pixels of each frame."),
                          HasSubstr("Of walk it is the tracer at full precision, on whole frames.")));
  EXPECT_THAT(html, Not(HasSubstr("bit-identical")));  // no two designs blend in one order
}

TEST_F(RunPictures, EachFrameOfASequenceHasItsSpeedUpAndItsPicture) {
  EXPECT_THAT(page(results()),
              AllOf(HasSubstr("frame by frame"),
                    HasSubstr("<td class=\"n\">4.50×</td><td class=\"n\">36.0 dB</td><td class=\"n\">identical</td>"),
                    HasSubstr("<td class=\"n\">3.50×</td><td class=\"n\">29.1 dB</td><td class=\"n\">82.3 dB</td>")));
}

TEST_F(RunPictures, ResultsOfAnOlderVersionSayNothingOfPictures) {
  ordered_json document = results();
  document.erase("pictures");
  EXPECT_THAT(page(document), AllOf(Not(HasSubstr(" dB")), HasSubstr("4.00×")));
}

TEST_F(RunPictures, ADamagedListOfPicturesIsRefused) {
  ordered_json document = results();
  document["pictures"]["walk"]["psnr"] = {"far"};
  EXPECT_ANY_THROW(page(document));
}

// "1.00x" of grtx, the reference, stood beside the paper's mean of 4.36 over the baseline.
TEST_F(RunPictures, ThePapersMeanStandsBesideSpeedUpsOverTheBaselineOnly) {
  ordered_json document = results();
  for (const char* part : {"designs", "inputs", "binding_bound", "pictures"}) {
    document[part]["grtx"] = document[part]["baseline"];
  }
  EXPECT_THAT(page(document), AllOf(HasSubstr("paper's mean, k = 8"), HasSubstr(">4.36×</td>")));
  for (const char* part : {"designs", "inputs", "binding_bound", "pictures"}) document[part].erase("baseline");
  document["speedup_over"] = "grtx";
  EXPECT_THAT(page(document), AllOf(Not(HasSubstr("paper's mean, k = 8")), Not(HasSubstr(">4.36×</td>"))));
}

// Captions said "k = 8" of gautracer's 16 and walk's 64, and "design baseline" over walk's area.
TEST_F(RunPictures, EachDesignIsCalledByItsOwnNameAndK) {
  const std::string html = page(results());
  EXPECT_THAT(html, AllOf(HasSubstr("k = 8 (walk 64)"), HasSubstr("<summary>Machine of walk</summary>"),
                          HasSubstr("hall, view 0, 64 × 64, k = 64, "), Not(HasSubstr("design baseline"))));
}

// "1.1e+02 times fewer".
TEST_F(RunPictures, FactorsAreInPlainDigits) {
  EXPECT_THAT(page(results()), HasSubstr("fetches 112 times fewer nodes"));
}

// "fetches inf times fewer nodes" of a design that fetches none.
TEST_F(RunPictures, ADesignWithoutFetchesHasNoRatioOfFetches) {
  ordered_json document = results();
  document["designs"]["walk"]["gpu.rt.node_fetches"] = count(0);
  EXPECT_THAT(page(document), Not(HasSubstr("fewer nodes")));
}

// "ports of the L2, 27 %" where one warp took 83 % of the run.
TEST_F(RunPictures, ASingleWarpThatTakesMostOfTheRunIsWhatBinds) {
  ordered_json document = results();
  const std::string html = page(document);
  EXPECT_THAT(
      html,
      AllOf(
          HasSubstr(
              "latency: the slowest call of a warp is 83 % of the run</strong>; of its resources the ports of the L2, "
              "at 27 %."),
          HasSubstr("the ports of the L2, 27 %")));  // of baseline, whose slowest warp is 10 %
  document["designs"]["walk"]["gpu.bound.fraction"] = count(0.9);
  EXPECT_THAT(page(document), Not(HasSubstr("latency: the slowest call")));
}

/// Adds what a speed-up is taken apart by: cycles of warps in traceRay calls, in shaders, and there waiting for memory.
void add_terms(ordered_json& design, double visits, double trace, double shaders, double waits) {
  const double cycles = design["gpu.cycles"]["value"].get<double>();
  for (const auto& [name, value] :
       {std::pair("gpu.rt.node_visits", visits), std::pair("gpu.rt.node_fetches", visits),
        std::pair("gpu.rt.node_fetch_latency", 100.0), std::pair("gpu.simt.instructions.total", 100.0),
        std::pair("gpu.simt.resident_warp_cycles", trace + shaders + waits),
        std::pair("gpu.simt.warp_cycles.trace", trace), std::pair("gpu.simt.warp_cycles.fetch", 0.0),
        std::pair("gpu.simt.warp_cycles.memory", waits), std::pair("gpu.simt.warp_cycles.drain", 0.0),
        std::pair("gpu.time_us", cycles)}) {
    design[name] = count(value);
  }
}

// The sentence said "19 times fewer nodes" and the waterfall below it "waits of shaders for memory x26"; walk over its
// rival stood nowhere.
TEST_F(RunPictures, TheAnswerNamesTheLargestTermsOfTheWaterfallAlsoOverTheNextDesign) {
  ordered_json document = results();
  document["designs"]["gautracer"] = document["designs"]["walk"];
  document["designs"]["gautracer"]["gpu.cycles"] = count(2000);
  document["inputs"]["gautracer"] = document["inputs"]["walk"];
  document["design_config"]["walk"]["rt.any_hit_unit.enabled"] = "true";
  add_terms(document["designs"]["baseline"], 2000, 10000, 2000, 20000);
  add_terms(document["designs"]["gautracer"], 2000, 14000, 1000, 1000);
  add_terms(document["designs"]["walk"], 1000, 6000, 1000, 1000);
  const std::string html = page(document);
  EXPECT_THAT(html,
              AllOf(HasSubstr("4.00 times as fast as baseline</strong>, most of it by waits of shaders for memory"),
                    HasSubstr("; and 2.00 times as fast as gautracer, the next, most of it by visits (1.76×)"),
                    HasSubstr("Of the 4.00 ms of baseline shading takes 2.75 ms and traversal 1.25 ms; of the "
                              "1.00 ms of walk, 0.250 ms and 0.750 ms. baseline keeps its hits in k-buffers in "
                              "memory, walk in heaps in registers."),
                    HasSubstr(">walk over gautracer</th>")));
  if (html.find("id=\"waterfall1\"") != std::string::npos) {  // built with charts
    EXPECT_THAT(html, HasSubstr("id=\"waterfall1_next\""));
  }
}

// "latency: one warp is 90 % of the run" was given as what binds the design, of an image that was too small.
TEST_F(RunPictures, AnImageThatDoesNotFillTheMachineIsSaidInTheAnswer) {
  ordered_json document = results();
  document.erase("frames");
  for (auto& [name, design] : document["designs"].items()) design["gpu.distributor.groups"] = count(128);
  EXPECT_THAT(page(document), HasSubstr("Mind: this image has 128 warps for 256 slots: too small to compare designs; "
                                        "take --width 128 --height 128 or more.</strong></p>"));
  for (auto& [name, design] : document["designs"].items()) design["gpu.distributor.groups"] = count(512);
  EXPECT_THAT(page(document), Not(HasSubstr("too small")));
}

// "What binds walk most is the ports of the L2: it alone takes 11 % of the cycles."
TEST_F(RunPictures, ASmallBoundIsNotSaidToBind) {
  ordered_json document = results();
  document["designs"]["walk"]["gpu.rt.warp_latency_max"] = count(100);
  EXPECT_THAT(page(document), AllOf(HasSubstr("No resource binds walk for half of its cycles: the largest lower bound, "
                                              "<strong>the ports of the L2</strong>, is 27 % of them."),
                                    Not(HasSubstr("What binds walk"))));
}

TEST_F(RunPictures, APartHasOneColourInAllCharts) {
  const auto colour = [](const std::vector<std::string>& parts, std::size_t of) {
    return stacked_bars(ordered_json::array(), parts, "", "", "")
        .at("encoding")
        .at("color")
        .at("scale")
        .at("range")
        .at(of)
        .get<std::string>();
  };
  const std::string nodes = colour({"nodes", "stacks"}, 0), other = colour({"shading", "nodes"}, 1);
  EXPECT_EQ(nodes.substr(0, nodes.find(',')), "var(--p-nodes");
  EXPECT_EQ(other.substr(0, other.find(',')), "var(--p-nodes");
  EXPECT_EQ(design_colour("walk"), "var(--d-walk, var(--c10))");
  EXPECT_EQ(design_colour("ellipsoid+checkpoint"), "var(--d-ellipsoid-checkpoint, var(--c10))");
}

}  // namespace
}  // namespace grtx::report
