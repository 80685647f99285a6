// SPDX-License-Identifier: Apache-2.0
// What shows where time goes, from the outside: waveform with its GTKWave files, timeline, heat maps, stall bars.
#include <gmock/gmock.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "apps/program.h"
#include "grtx/frontend/image/image.h"
#include "paths.h"
#include "rtl_tlm/tiny_trace.h"

namespace grtx::e2e {
namespace {

using ::testing::HasSubstr;

const std::string kSmallQuietly =
    std::string("--quiet --config '") + grtx::paths::source_dir() + "/configs/small.toml' ";

class CliObserve : public ::testing::Test {
 protected:
  CliObserve() { sim::test::write_tiny_trace(folder_.path("t.grtx")); }
  Folder folder_;
};

TEST_F(CliObserve, WaveformComesWithASaveFileAndFilters) {
  ASSERT_EQ(folder_.run("sim t.grtx " + kSmallQuietly + "--vcd w.vcd --vcd-level units").code, 0);
  EXPECT_THAT(folder_.read("w.vcd"), HasSubstr("$comment\ntrace "));
  EXPECT_THAT(folder_.read("w.gtkw"), HasSubstr("-gpu.sm0.rt.rt_scheduler\n"));
  EXPECT_THAT(folder_.read("w.stall_reason.filter"), HasSubstr("?any_hit\n"));
  EXPECT_FALSE(folder_.has("w.warp_state.filter"));  // no warps at this level
}

TEST_F(CliObserve, GtkwaveShowsTheSaveFile) {
  ASSERT_EQ(folder_.run("sim t.grtx " + kSmallQuietly + "--vcd w.vcd --vcd-scope 'sm0.rt*' --vcd-window 200:800").code,
            0);
  const int status = std::system(("timeout 100 '" + grtx::paths::source_dir() + "/scripts/gtkwave_screenshot.sh' '" +
                                  folder_.path("w.gtkw") + "' '" + folder_.path("w.png") + "' 2>/dev/null")
                                     .c_str());
  if (WEXITSTATUS(status) == 3) GTEST_SKIP() << "gtkwave, xvfb, xauth or imagemagick is not installed";
  ASSERT_EQ(status, 0);
  const frontend::Image picture = frontend::read_image(folder_.path("w.png"));
  EXPECT_GE(picture.width, 800U);
  // Words of enumerations lie on their colours: royal blue is `memory`, forest green is `ready`.
  std::size_t blue = 0;
  for (const glm::vec3& p : picture.pixels) {
    if (p.b > 0.7f && p.r < 0.4f && p.g > 0.3f && p.g < 0.5f) ++blue;
  }
  EXPECT_GT(blue, 500U);
}

TEST_F(CliObserve, TimelineIsJsonWithTracksAndCounters) {
  ASSERT_EQ(folder_.run("sim t.grtx " + kSmallQuietly + "--timeline t.json --timeline-window :900").code, 0);
  const auto json = nlohmann::json::parse(folder_.read("t.json"));
  EXPECT_GT(json.at("traceEvents").size(), 50U);
  EXPECT_EQ(json.at("otherData").at("trace").get<std::string>().size(), 16U);
}

TEST_F(CliObserve, HeatMapOfCyclesHasTheRawNumbers) {
  ASSERT_EQ(folder_.run("sim t.grtx " + kSmallQuietly + "--stats s.json --heatmap cycles=c.png").code, 0);
  const frontend::Image raw = frontend::read_image(folder_.path("c.exr"));
  EXPECT_EQ(raw.width, 32U);
  EXPECT_EQ(raw.height, 4U);
  const auto stats = nlohmann::json::parse(folder_.read("s.json")).at("stats");
  double warp_cycles = 0;  // every row is a warp
  for (unsigned y = 0; y < raw.height; ++y) {
    for (unsigned x = 0; x < raw.width; ++x) EXPECT_EQ(raw.at(x, y).r, raw.at(0, y).r);
    warp_cycles += static_cast<double>(raw.at(0, y).r);
    EXPECT_LE(raw.at(0, y).r, stats.at("gpu.cycles").at("value").get<float>());
  }
  // From launch to end: the time in the SM, and a cycle each way on the links.
  EXPECT_EQ(warp_cycles, stats.at("gpu.simt.resident_warp_cycles").at("value").get<double>() + 4 * 2);
  const frontend::Image picture = frontend::read_image(folder_.path("c.png"));
  EXPECT_GT(picture.width, 32U * 12);  // enlarged, with title and colour bar
}

TEST_F(CliObserve, HeatMapsOfTheTracerAddUpToItsCounters) {
  ASSERT_EQ(folder_.run("synth --quiet --preset object --count 300 --seed 3 -o s.ply").code, 0);
  const Outcome outcome = folder_.run(
      "trace --quiet --scene s.ply --cameras s.cameras.json --width 24 --height 16 --checkpoint on --no-trace --stats "
      "s.json --heatmap visits --heatmap rounds=r.png --heatmap blended --heatmap checkpoint_entries");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto stats = nlohmann::json::parse(folder_.read("s.json")).at("stats");
  const auto sum = [&](const std::string& file) {
    double total = 0;
    for (const glm::vec3& p : frontend::read_image(folder_.path(file)).pixels) total += static_cast<double>(p.r);
    return total;
  };
  const auto counter = [&](const std::string& name) { return stats.at("tracer." + name).at("value").get<double>(); };
  EXPECT_GT(counter("visits.total"), 0);
  EXPECT_EQ(sum("visits.exr"), counter("visits.total"));
  EXPECT_EQ(sum("r.exr"), counter("rounds"));
  EXPECT_EQ(sum("blended.exr"), counter("blended"));
  EXPECT_EQ(sum("checkpoint_entries.exr"), counter("checkpoint.written"));
  EXPECT_TRUE(folder_.has("visits.png"));
}

TEST_F(CliObserve, StallsPrintsBars) {
  ASSERT_EQ(folder_.run("sim t.grtx " + kSmallQuietly + "--stats s.json").code, 0);
  const Outcome outcome = folder_.run("stalls s.json --columns 20");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("gpu.rt: every cycle of every RT scheduler"));
  EXPECT_THAT(outcome.out, HasSubstr("memory"));
  EXPECT_THAT(outcome.out, HasSubstr("|####"));
}

TEST_F(CliObserve, StallsReadsADesignOfARun) {
  ASSERT_EQ(folder_.run("sim t.grtx " + kSmallQuietly + "--stats s.json").code, 0);
  const auto document = nlohmann::ordered_json::parse(folder_.read("s.json"));
  nlohmann::ordered_json run = {{"schema", "grtx.run/1"}, {"config", document.at("config")}};
  run["designs"] = {{"hw", document.at("stats")}, {"sw", document.at("stats")}};
  folder_.write("results.json", run.dump());
  EXPECT_EQ(folder_.run("stalls results.json --design hw").out, folder_.run("stalls s.json").out);
  for (const auto& [arguments, what] :
       {std::pair("stalls results.json", "results.json: designs: --design must name one of hw, sw\n"),
        std::pair("stalls results.json --design grtx", "results.json: designs: --design must name one of hw, sw\n"),
        std::pair("stalls s.json --design hw", "stalls: --design: is for results.json of grtx run\n")}) {
    const Outcome outcome = folder_.run(arguments);
    EXPECT_EQ(outcome.code, 2);
    EXPECT_EQ(outcome.err, std::string("grtx: ") + what);
  }
  run["machine"] = "ada, changed";
  const nlohmann::ordered_json several = {{"schema", "grtx.run/2"}, {"machines", {run, {{"machine", "paper"}}}}};
  folder_.write("results.json", several.dump());
  EXPECT_EQ(folder_.run("stalls results.json --design hw --machine ada").out, folder_.run("stalls s.json").out);
  EXPECT_EQ(folder_.run("stalls results.json --design hw").err,
            "grtx: results.json: machines: --machine must name one of ada, paper\n");
}

TEST_F(CliObserve, BadInputIsOneLine) {
  folder_.write("x.json", "{");
  folder_.write("y.json", "{\"schema\": \"other\"}");
  for (const std::string arguments :
       {"stalls x.json", "stalls y.json", "sim t.grtx --heatmap cycle", "sim t.grtx --heatmap cycles=c.jpg",
        "sim t.grtx --vcd w.vcd --vcd-level all", "sim t.grtx --vcd w.vcd --vcd-scope nothing",
        "sim t.grtx --timeline t.json --timeline-window 9:1"}) {
    const Outcome outcome = folder_.run(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
  EXPECT_FALSE(folder_.has("w.vcd"));
}

}  // namespace
}  // namespace grtx::e2e
