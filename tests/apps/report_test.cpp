// SPDX-License-Identifier: Apache-2.0
// grtx report through the program: what it reads, what it refuses, what a page holds without JavaScript.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "apps/program.h"
#include "grtx/base/atomic_file.h"
#include "paths.h"
#include "sweep_database.h"

namespace grtx::e2e {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// A grid on the configuration that the program itself resolves.
void make_grid(const Folder& folder, const std::string& name) {
  const Outcome cost = folder.run("cost --json");
  ASSERT_EQ(cost.code, 0) << cost.err;
  testing_sweep::make_grid(folder.path(name), nlohmann::json::parse(cost.out).at("config").dump());
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

TEST(Report, ASweepHasItsPointsInATable) {
  const Folder folder;
  make_grid(folder, "grid.sqlite");
  const Outcome outcome = folder.run("report grid.sqlite -o r.html");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const std::string page = folder.read("r.html");
  EXPECT_EQ(count(page, "<tr data-id="), 58u);
  EXPECT_THAT(page, HasSubstr("58 / 60"));
  EXPECT_THAT(page, HasSubstr("watchdog: &lt;no progress&gt;"));  // why #7 failed
  EXPECT_THAT(page, HasSubstr("longer than 20 s"));
  // Least time: w = 20, l = 16, b = 128, k = 8 -> 1000 + 300 + 18.75 + 156.25 us, and 10 + 4 + 0.8 + 2.56 mm2.
  EXPECT_THAT(page, HasSubstr("<dt>Least time</dt><dd>1,475 µs</dd>"));
  EXPECT_THAT(page, HasSubstr("<td class=\"n\">17.36</td>"));
  EXPECT_THAT(page, HasSubstr("2,658 B"));  // checkpoint storage of 20 warps: 132 x 20 + 18
}

// Those of gautracer stood apart, and the page of a run priced its machine without its own units.
TEST(Report, StatisticsOfTwoDesignsStandSideBySideEachOnItsMachine) {
  const Folder folder;
  ASSERT_EQ(folder.run("synth --preset object --count 400 --seed 1 -o s.ply --quiet").code, 0);
  ASSERT_EQ(folder
                .run("run --scene s.ply --cameras s.cameras.json --width 8 --height 8 --mode cycle --designs "
                     "baseline,gautracer -o out --quiet")
                .code,
            0);
  const auto results = nlohmann::json::parse(folder.read("out/results.json"));
  std::string keys;
  for (const auto& [key, value] : results.at("design_config").at("gautracer").items()) {
    keys += " --set " + key + "=" + value.get<std::string>();
  }
  ASSERT_EQ(folder.run("sim out/baseline.grtx --stats b.json --quiet").code, 0);
  ASSERT_EQ(folder.run("sim out/gautracer.grtx --stats g.json --quiet" + keys).code, 0);
  ASSERT_EQ(folder.run("report g.json b.json -o r.html").code, 0);
  const std::string speedup = fmt::format("{:.2f}×", results.at("speedup").at("gautracer").get<double>());
  for (const char* file : {"out/report.html", "r.html"}) {
    EXPECT_THAT(folder.read(file), AllOf(HasSubstr("Speed-up over baseline by design"), HasSubstr(speedup),
                                         HasSubstr(">ray_gaussian</span>"), HasSubstr(">any_hit_unit</span>"),
                                         Not(HasSubstr("In what the runs differ"))))
        << file;
  }
}

TEST(Report, ResultsWithoutInputsArePricedAsTheirDesign) {
  const Folder folder;
  ASSERT_EQ(folder.run("synth --preset object --count 400 --seed 1 -o s.ply --quiet").code, 0);
  ASSERT_EQ(folder
                .run("run --scene s.ply --cameras s.cameras.json --width 8 --height 8 --mode cycle --designs "
                     "gautracer,walk -o out --quiet")
                .code,
            0);
  auto results = nlohmann::json::parse(folder.read("out/results.json"));
  const std::string with = folder.read("out/report.html");
  results.erase("inputs");
  folder.write("bare.json", results.dump());
  ASSERT_EQ(folder.run("report bare.json -o bare.html").code, 0);
  const std::string bare = folder.read("bare.html");
  for (const char* unit : {">ray_gaussian</span>", ">ray_triangle</span>", ">any_hit_unit</span>"}) {
    EXPECT_EQ(count(bare, unit), count(with, unit)) << unit;
  }
  EXPECT_EQ(count(bare, ">ray_gaussian</span>"), 2u);
  results["designs"]["mine"] = results.at("designs").at("walk");
  folder.write("mine.json", results.dump());
  ASSERT_EQ(folder.run("report mine.json -o mine.html").code, 0);
  EXPECT_THAT(folder.read("mine.html"), HasSubstr("cannot price this machine: mine.json: inputs: must name accel"));
}

TEST(Report, TheSameInputsGiveTheSameBytes) {
  const Folder folder;
  make_grid(folder, "grid.sqlite");
  ASSERT_EQ(folder.run("report grid.sqlite -o a.html").code, 0);
  ASSERT_EQ(folder.run("report grid.sqlite -o b.html").code, 0);
  EXPECT_EQ(folder.read("a.html"), folder.read("b.html"));
}

TEST(Report, NothingOfAPageComesFromElsewhere) {
  const Folder folder;
  make_grid(folder, "grid.sqlite");
  ASSERT_EQ(folder.run("report grid.sqlite -o r.html").code, 0);
  const std::string whole = folder.read("r.html");
  EXPECT_THAT(whole, Not(HasSubstr("sourceMappingURL")));
  const std::string page = whole.substr(0, whole.find("</footer>"));  // the chart library's own text comes behind
  EXPECT_EQ(count(page, " src="), count(page, " src=\"data:"));
  EXPECT_EQ(count(page, "<link"), 1u);
  EXPECT_THAT(page, HasSubstr("<link rel=\"icon\" href=\"data:,\">"));
  EXPECT_THAT(page, HasSubstr("content=\"default-src 'none'; img-src data:;"));  // and the browser holds it to that
  EXPECT_THAT(page, Not(HasSubstr("@import")));
  EXPECT_THAT(page, Not(HasSubstr("url(")));
}

TEST(Report, InputIsTextAndNeverMarkup) {
  const Folder folder;
  const std::string evil = "</script><script>alert(1)</script>\"'&";
  testing_sweep::make_points(folder.path("evil.sqlite"),
                             {{{"id", 1},
                               {"scene", evil},
                               {"design", evil},
                               {"coordinates", {{evil, evil}}},
                               {"values", {{"gpu.time_us", 1.0}, {"cost.mm2", 2.0}, {"gpu.rt.stall." + evil, 1.0}}}},
                              {{"id", 2}, {"status", "failed"}, {"reason", evil}, {"coordinates", {{evil, "b"}}}}});
  testing_sweep::execute(folder.path("evil.sqlite"),
                         "INSERT OR REPLACE INTO meta VALUES ('plan', " + testing_sweep::quoted(evil) + ")");
  const Outcome outcome = folder.run("report evil.sqlite -o r.html --title '<b>bold</b>'");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const std::string page = folder.read("r.html");
  EXPECT_THAT(page, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(page, Not(HasSubstr("<b>bold")));
  EXPECT_GE(count(page, "&lt;/script&gt;&lt;script&gt;alert(1)&lt;/script&gt;&quot;&#39;&amp;"), 5u);
  EXPECT_THAT(page, HasSubstr("<title>&lt;b&gt;bold&lt;/b&gt;</title>"));
}

TEST(Report, ARunWritesItsReport) {
  const Folder folder;
  ASSERT_EQ(folder.run("synth --preset object --count 1500 --seed 7 -o s.ply --quiet").code, 0);
  const Outcome run = folder.run("run --scene s.ply --cameras s.cameras.json --view 0 --width 16 --height 8 --config " +
                                 grtx::paths::source_dir() + "/configs/small.toml --quiet -o out");
  ASSERT_EQ(run.code, 0) << run.err;
  const std::string page = folder.read("out/report.html");
  for (const char* part : {"Speed-up, GRTX-SW", "Storage added to an RT core", "Fewer L2 accesses, GRTX",
                           "src=\"data:image/png;base64,iVBOR", "gpu.rt.stall.memory", "rt.warp_buffer.entries"}) {
    EXPECT_THAT(page, HasSubstr(part));
  }
  EXPECT_THAT(page, Not(HasSubstr("host.wall_seconds")));
  const nlohmann::json results = nlohmann::json::parse(folder.read("out/results.json"));
  char speedup[48];
  std::snprintf(speedup, sizeof(speedup), "<span class=\"figure\">%.2f×",
                results.at("speedup").at("walk").get<double>());  // the fastest
  EXPECT_THAT(page, HasSubstr(speedup));
}

TEST(Report, SimulationsOfOneViewAreComparedWithEachOther) {
  const Folder folder;
  ASSERT_EQ(folder.run("synth --preset object --count 1500 --seed 7 -o s.ply --quiet").code, 0);
  const std::string config = " --config " + grtx::paths::source_dir() + "/configs/small.toml --quiet";
  for (const char* design : {"tri20", "tlas-tri20"}) {
    ASSERT_EQ(folder
                  .run(std::string("trace --scene s.ply --cameras s.cameras.json --view 0 --width 16 --height 8 "
                                   "--checkpoint off --quiet --accel ") +
                       design + " -o t.grtx")
                  .code,
              0);
    ASSERT_EQ(folder.run("sim t.grtx --stats " + std::string(design) + ".json" + config).code, 0);
  }
  const Outcome outcome = folder.run("report tri20.json tlas-tri20.json -o r.html");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(folder.read("r.html"), AllOf(HasSubstr("Speed-up, GRTX-SW"), HasSubstr(", machine paper")));
  ASSERT_EQ(folder.run("report tlas-tri20.json -o one.html").code, 0);
  EXPECT_THAT(folder.read("one.html"), Not(HasSubstr("Speed-up, GRTX-SW")));
}

// A baseline of 16 x 8 rays beside a grtx of 32 x 16, of another field of view, transmittance, mode or warmth was a
// speed-up.
TEST(Report, StatisticsOfAnotherViewOrModeAreNoSpeedUp) {
  const Folder folder;
  const auto must = [&](const std::string& arguments) {
    const Outcome outcome = folder.run(arguments + " --quiet");
    ASSERT_EQ(outcome.code, 0) << arguments << ": " << outcome.err;
  };
  must("synth --preset object --count 1500 --seed 7 -o s.ply");
  const auto simulate = [&](const std::string& name, const std::string& accel, const std::string& size,
                            const std::string& traced, const std::string& simulated) {
    must("trace --scene s.ply --cameras s.cameras.json --accel " + accel + " " + size + " " + traced + " -o t.grtx");
    must("sim t.grtx --set gpu.sms=1 --stats " + name + " " + simulated);
  };
  const std::string size = "--width 16 --height 8", baseline = "tri20 --checkpoint off";
  const std::string grtx = "tlas-tri20 --checkpoint on";
  simulate("b.json", baseline, size, "--view 0", "");
  simulate("g.json", grtx, size, "--view 0", "");
  const auto page = [&](const std::string& files) {
    must("report " + files + " -o r.html");
    const std::string whole = folder.read("r.html");
    return whole.substr(0, whole.find("</footer>"));
  };
  EXPECT_THAT(page("b.json g.json"), AllOf(HasSubstr("times as fast as baseline"), Not(HasSubstr("the runs differ"))));
  struct Case {
    const char *size, *traced, *simulated;
    const char* difference;  ///< cells of the baseline's and of the other's, in the table of what differs
  };
  for (const Case& c : {Case{"--width 32 --height 16", "--view 0", "", "size</th><td>16 × 8</td><td>32 × 16"},
                        Case{nullptr, "--view 1", "", "view</th><td>"},
                        Case{nullptr, "--view 0 --fov-scale 0.5", "", "fov_scale</th><td>1</td><td>0.5"},
                        Case{nullptr, "--view 0 --ert 0.5", "", "ert</th><td>0.001</td><td>0.5"},
                        Case{nullptr, "--view 0 --k 4", "", "k</th><td>8</td><td>4"},
                        Case{nullptr, "--view 0 --secondary glass", "", "secondary</th><td>none</td><td>glass"},
                        Case{nullptr, "--view 0", "--set l1.bytes=65536", "l1.bytes</th><td>"},
                        Case{nullptr, "--view 0", "--machine ada-share", "machine</th><td>"},
                        Case{nullptr, "--view 0", "--mode windows --share 1", "mode</th><td>cycle</td><td>windows"},
                        Case{nullptr, "--view 0", "--warm g.grtx", "warm.camera_hash</th><td></td><td>"}}) {
    if (std::string(c.simulated).find("--warm") != std::string::npos) {
      must("trace --scene s.ply --cameras s.cameras.json --accel " + grtx + " " + size + " --view 0 -o g.grtx");
    }
    simulate("other.json", grtx, c.size == nullptr ? size : c.size, c.traced, c.simulated);
    EXPECT_THAT(page("b.json other.json"), AllOf(Not(HasSubstr("times as fast")), HasSubstr(c.difference)))
        << c.traced << c.simulated;
  }
}

/// What docs/model/figures.md calls the tables and charts of a page.
std::vector<std::string> listed_figures() {
  const std::string page = read_file(grtx::paths::source_dir() + "/docs/model/figures.md");
  std::istringstream lines(page.substr(page.find("## On the pages")));
  std::vector<std::string> names;
  for (std::string line; std::getline(lines, line) && !line.starts_with("## Elsewhere");) {
    const std::string cell = line.starts_with("| ") ? line.substr(2, line.find(" | ") - 2) : "";
    for (std::size_t at = cell.find('`'); at != std::string::npos; at = cell.find('`', at + 1)) {
      const std::size_t end = cell.find('`', at + 1);
      names.push_back(cell.substr(at + 1, end - at - 1));
      at = end;
    }
  }
  return names;
}

// Tables of the inputs, of the configuration and of what has no result aside. Each is in the list of figures.
TEST(Report, EveryTableSaysItsMachineItsModeAndTheVersionOfTheModel) {
  const Folder folder;
  ASSERT_EQ(folder.run("synth --preset object --count 1500 --seed 7 -o s.ply --quiet").code, 0);
  const Outcome run = folder.run("run --scene s.ply --cameras s.cameras.json --view 0 --width 16 --height 8 --config " +
                                 grtx::paths::source_dir() + "/configs/small.toml --quiet -o out");
  ASSERT_EQ(run.code, 0) << run.err;
  make_grid(folder, "grid.sqlite");
  testing_sweep::execute(folder.path("grid.sqlite"),
                         "UPDATE point SET document = json_set(document, '$.inputs', json('{\"machine\": \"paper\"}')) "
                         "WHERE status = 'done'; INSERT OR REPLACE INTO meta VALUES ('model_version', '7')");
  const Outcome made = folder.run("report out/results.json grid.sqlite -o r.html");
  ASSERT_EQ(made.code, 0) << made.err;
  const std::string page = folder.read("r.html");
  const std::string begin = "<caption><span>";
  std::size_t figures = 0;
  const std::vector<std::string> listed = listed_figures();
  ASSERT_GE(listed.size(), 15u);
  for (std::size_t at = page.find(begin); at != std::string::npos; at = page.find(begin, at + 1)) {
    std::string caption = page.substr(at + begin.size(), page.find("</span>", at) - at - begin.size());
    for (std::size_t quote; (quote = caption.find("&#39;")) != std::string::npos;) caption.replace(quote, 5, "'");
    const auto is_of = [&caption](const char* words) { return caption.find(words) != std::string::npos; };
    if (is_of("What this page was made of") || is_of("inputs of the simulations") || is_of("Every key of") ||
        is_of("points without a result") || is_of("traces")) {
      continue;
    }
    ++figures;
    const auto names_it = [&caption](const std::string& name) { return caption.find(name) != std::string::npos; };
    EXPECT_TRUE(std::any_of(listed.begin(), listed.end(), names_it)) << "docs/model/figures.md lacks: " << caption;
    EXPECT_THAT(caption, HasSubstr("machine")) << caption;
    EXPECT_THAT(caption, AllOf(HasSubstr("mode cycle"), HasSubstr("model version"))) << caption;
  }
  EXPECT_GE(figures, 20u);
}

TEST(Report, BadInputIsOneLine) {
  const Folder folder;
  folder.write("empty", "");
  folder.write("garbage.json", "{\"schema\": ");
  folder.write("other.json", R"({"schema": "grtx.cost/1"})");
  folder.write("half.json", R"({"schema": "grtx.run/1", "config": {}})");
  folder.write("hollow.json", R"({"schema": "grtx.run/1", "config": {}, "designs": {"a": {"gpu.cycles": 3}}})");
  folder.write("ok.json", R"({"schema": "grtx.stats/1", "config": {}, "inputs": {}, "stats": {}})");
  folder.write("picture.png", "no picture");
  folder.write("torn.sqlite", std::string("SQLite format 3\0", 16) + "rubbish");
  testing_sweep::execute(folder.path("foreign.sqlite"), "CREATE TABLE t(a)");
  testing_sweep::execute(folder.path("old.sqlite"),
                         "CREATE TABLE meta(key, value); INSERT INTO meta VALUES ('schema', 'grtx.sweep/0')");
  testing_sweep::make_points(folder.path("json.sqlite"), nlohmann::json::parse(R"([{"id": 1}])"));
  testing_sweep::execute(folder.path("json.sqlite"), "UPDATE point SET coordinates = '[1'");
  for (const char* arguments :
       {"missing.json", "empty", "garbage.json", "other.json", "half.json", "hollow.json", "torn.sqlite",
        "foreign.sqlite", "old.sqlite", "json.sqlite", "ok.json --image picture.png", "ok.json --image missing.png"}) {
    const Outcome outcome = folder.run(std::string("report ") + arguments + " -o r.html");
    EXPECT_EQ(outcome.code, 2) << arguments << ": " << outcome.err;
    EXPECT_TRUE(is_one_error_line(outcome.err)) << arguments << ": " << outcome.err;
    EXPECT_FALSE(folder.has("r.html")) << arguments;
  }
  EXPECT_EQ(folder.run("report -o r.html").code, 2);
  EXPECT_EQ(folder.run("report ok.json").code, 2);
  EXPECT_EQ(folder.run("report ok.json -o no/folder/r.html").code, 2);
}

}  // namespace
}  // namespace grtx::e2e
