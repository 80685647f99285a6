// SPDX-License-Identifier: Apache-2.0
// grtx ray: pages of every structure and mechanism, what they say, and what is refused.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/program.h"

namespace grtx::e2e {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kScene = "--scene s.ply --cameras s.cameras.json ";
const std::string kTrace = "trace --quiet --width 16 --height 16 " + kScene;

/// The description that a page holds for its script.
json description(const std::string& page) {
  const std::string begin = "<script type=\"application/json\" id=\"page\">";
  const std::size_t at = page.find(begin) + begin.size();
  return json::parse(page.substr(at, page.find("</script>", at) - at));
}

class Ray : public ::testing::Test {
 protected:
  Ray() {
    EXPECT_EQ(folder_.run("synth --preset object --count 2000 --seed 7 --sh-degree 1 -o s.ply --quiet").code, 0);
  }

  void make(const std::string& arguments) {
    const Outcome made = folder_.run(kTrace + arguments + " -o t.grtx");
    ASSERT_EQ(made.code, 0) << arguments << ": " << made.err;
  }
  /// The page, which must be made.
  std::string page(const std::string& arguments) {
    const Outcome made = folder_.run("ray t.grtx --quiet -o r.html " + arguments);
    EXPECT_EQ(made.code, 0) << made.err;
    return folder_.read("r.html");
  }
  void expect_refused(const std::string& arguments, const std::string& what) {
    const Outcome outcome = folder_.run("ray " + arguments);
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_TRUE(is_one_error_line(outcome.err)) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(what)) << arguments;
    EXPECT_FALSE(folder_.has("r.html")) << arguments;
  }

  Folder folder_;
};

// The page showed one design: whether the pixel is slow in another took a second page.
TEST_F(Ray, TheSamePixelInAnotherDesignStandsBesideIt) {
  make("--accel tri20");
  ASSERT_EQ(folder_.run(kTrace + "--accel tlas-tri20 --checkpoint on -o u.grtx").code, 0);
  const std::string both = page("--pixel 7,7 --beside u.grtx");
  EXPECT_THAT(both, HasSubstr("The same pixel in other traces of the view"));
  EXPECT_THAT(both, HasSubstr("tlas-tri20, checkpoints on, k = 8"));
  EXPECT_GT(description(both).at("median").get<int>(), 0);
  EXPECT_THAT(page("--pixel 7,7"), Not(HasSubstr("The same pixel in other traces")));
  std::filesystem::remove(folder_.path("r.html"));
  ASSERT_EQ(folder_.run("trace --quiet --width 8 --height 16 " + kScene + "--accel tri20 -o v.grtx").code, 0);
  expect_refused("t.grtx -o r.html --pixel 7,7 --beside v.grtx", "is of another size than t.grtx");
}

// "Which pixel is slow?" had no command.
TEST_F(Ray, TheSlowestAreListedWithTheirVisitsAndTheNextCommand) {
  make("--accel tlas-tri20 --checkpoint on --stats s.json");
  const json all = json::parse(folder_.run("ray t.grtx --slowest 1000000 --json").out);
  std::uint64_t visits = 0, before = ~std::uint64_t{0};
  for (const json& ray : all.at("slowest")) {
    visits += ray.at("visits").get<std::uint64_t>();
    EXPECT_LE(ray.at("visits"), before);
    before = ray.at("visits");
  }
  EXPECT_EQ(all.at("slowest").size(), 256U);
  EXPECT_EQ(visits, json::parse(folder_.read("s.json")).at("stats").at("tracer.visits.total").at("value"));
  const json first = all.at("slowest").front();
  const std::string pixel = first.at("pixel")[0].dump() + "," + first.at("pixel")[1].dump();
  const Outcome listed = folder_.run("ray t.grtx --slowest 3");
  EXPECT_EQ(std::count(listed.out.begin(), listed.out.end(), '\n'), 5) << listed.out;  // title, three, next
  EXPECT_THAT(listed.out, HasSubstr("\n" + pixel + " "));
  EXPECT_THAT(listed.out, HasSubstr("next: grtx ray t.grtx --pixel " + pixel + " -o ray.html\n"));
  expect_refused("t.grtx --pixel 3,3", "a page is needed, or --slowest N");
}

// "988.0x of median": the median ray saw the sky, which is one visit.
TEST_F(Ray, TheMedianIsOfRaysThatHitSomething) {
  make("--accel tri20 --fov-scale 4");
  const json listed = json::parse(folder_.run("ray t.grtx --slowest 1000000 --json").out);
  std::vector<std::uint64_t> all;
  for (const json& ray : listed.at("slowest")) all.push_back(ray.at("visits"));
  EXPECT_EQ(all[all.size() / 2], all.back());  // most rays miss: they visit as few nodes as any
  EXPECT_GT(listed.at("median_visits").get<std::uint64_t>(), all.back());
}

// "memory 93,104 cycles" of the time axis is the shader's wait, elsewhere the word is the RT unit's.
TEST_F(Ray, TheTimeAxisCallsTheWaitOfAShaderSo) {
  make("--accel tri20");
  EXPECT_THAT(page("--pixel 7,7"), HasSubstr("shader waits for memory"));
}

struct RayCase {
  const char* name;
  const char* options;
};

class RayOf : public Ray, public ::testing::WithParamInterface<RayCase> {};

// With the scene the tracer's k-buffer is compared with the replay's at the start of each round, and every event with
// the trace's: a page that is made agrees with both.
TEST_P(RayOf, IsShownWithAndWithoutTheScene) {
  make(GetParam().options);
  const Outcome dump = folder_.run("trace-dump --json t.grtx");
  std::istringstream lines(dump.out);
  std::string line;
  std::getline(lines, line);
  std::vector<json> groups;
  while (std::getline(lines, line)) groups.push_back(json::parse(line));
  for (const std::string& arguments : {std::string("--warp 3"), "--warp 3 " + kScene}) {
    const json shown = description(page(arguments));
    std::size_t ray = 0;
    for (const json& traced : groups.at(3).at("rays")) {
      if (traced.at("rounds").empty()) continue;
      const json& rounds = shown.at("rays").at(ray++).at("rounds");
      ASSERT_EQ(rounds.size(), traced.at("rounds").size());
      for (std::size_t r = 0; r < rounds.size(); ++r) {
        EXPECT_EQ(rounds[r].at("events"), traced.at("rounds")[r][0]);
        EXPECT_EQ(rounds[r].at("hits"), traced.at("rounds")[r][5]);
      }
    }
    EXPECT_EQ(shown.at("rays").size(), ray);
    EXPECT_EQ(shown.at("rays")[0].at("values"), arguments != "--warp 3");
  }
}

INSTANTIATE_TEST_SUITE_P(
    Every, RayOf,
    ::testing::Values(RayCase{"baseline", "--accel tri20"}, RayCase{"hw", "--accel tri20 --checkpoint on"},
                      RayCase{"sw", "--accel tlas-tri20"}, RayCase{"grtx", "--accel tlas-tri20 --checkpoint on"},
                      RayCase{"tri80", "--accel tri80 --checkpoint on"},
                      RayCase{"tlas_tri80", "--accel tlas-tri80 --checkpoint on"},
                      RayCase{"ellipsoid", "--accel ellipsoid --checkpoint on --k 3"},
                      RayCase{"tlas_sphere", "--accel tlas-sphere --checkpoint on --k 3"},
                      RayCase{"compact", "--accel tri20 --layout compact --checkpoint on"},
                      RayCase{"compressed", "--accel tlas-tri20 --layout compressed --checkpoint on"},
                      RayCase{"lifo", "--accel tlas-tri20 --checkpoint on --checkpoint-order lifo --k 4"},
                      RayCase{"nearest", "--accel tlas-tri20 --checkpoint on --checkpoint-order nearest --k 4"},
                      RayCase{"vulkan_sim", "--accel tlas-tri20 --checkpoint on --child-order vulkan_sim --k 4"},
                      RayCase{"paper", "--machine paper --accel tlas-tri20 --checkpoint on"},
                      RayCase{"kth",
                              "--accel tri20 --checkpoint on --tmax-update kth --replay-tmax kth --pop-test off --k 4"},
                      RayCase{"overflow", "--accel tlas-tri20 --checkpoint on --checkpoint-capacity 8 --k 4"},
                      RayCase{"single", "--accel tri20 --tracing single --k 8"},
                      RayCase{"closest", "--accel tlas-tri20 --tracing closest"},
                      RayCase{"stored_triangles", "--accel tri20 --triangle-test world --checkpoint on"},
                      RayCase{"linear", "--accel tlas-tri20 --checkpoint on --mapping linear --warp-size 8"}),
    [](const auto& one) { return one.param.name; });

// It wrote before the begin of the k-buffer, and ended by a signal.
TEST_F(Ray, OfAWalkIsShownWithAndWithoutTheScene) {
  make("--accel ellipsoid --layout quantised --k 16 --ahead 16");
  for (int warp = 0; warp < 8; ++warp) {
    const std::string shown = page("--warp " + std::to_string(warp));
    EXPECT_EQ(description(shown).at("ahead"), 16);
    EXPECT_THAT(shown, HasSubstr("up to 16 nodes of a ray under way"));
    const json traced_again = description(page("--warp " + std::to_string(warp) + " " + kScene));
    EXPECT_EQ(traced_again.at("rays")[0].at("values"), true);
  }
}

TEST_F(Ray, OfAPixelHoldsWhatGlassAndMirrorMakeOfIt) {
  make("--accel tlas-tri20 --checkpoint on --secondary both");
  std::size_t most = 0;
  for (const char* pixel : {"4,4", "8,8", "8,12"}) {
    for (const std::string& scene : {std::string(), kScene}) {
      const json shown = description(page(std::string("--pixel ") + pixel + " " + scene));
      most = std::max(most, shown.at("rays").size());
      EXPECT_EQ(shown.at("rays")[0].at("name").get<std::string>().find(std::string("pixel ") + pixel + " ("), 0u);
    }
  }
  EXPECT_GT(most, 1u);
}

TEST_F(Ray, OfAPlacedObjectAndOfAFrame) {
  folder_.write("o.json", R"([{"file": "s.ply"}, {"file": "s.ply", "translate": [1, 0, 0]}])");
  ASSERT_EQ(folder_
                .run("trace --quiet --width 16 --height 16 --scene o.json --cameras s.cameras.json --views 0:1 "
                     "--accel tlas-tri20 --checkpoint on -o t.grtx")
                .code,
            0);
  const json shown = description(page("--pixel 8,8 --frame 1 --scene o.json --cameras s.cameras.json --view 1"));
  EXPECT_THAT(shown.at("rays")[0].at("name").get<std::string>(), HasSubstr("frame 1"));
  EXPECT_EQ(description(page("--pixel 8,8 --frame 1")).at("rays")[0].at("rounds").size(),
            shown.at("rays")[0].at("rounds").size());
}

TEST_F(Ray, PageIsTheSameEachTimeAndHoldsAll) {
  make("--accel tlas-tri20 --checkpoint on");
  const std::string first = page("--pixel 8,8 " + kScene);
  EXPECT_EQ(first, page("--pixel 8,8 " + kScene));
  EXPECT_THAT(first, Not(HasSubstr("src=")));
  EXPECT_THAT(first, AllOf(Not(HasSubstr("http:")), Not(HasSubstr("https:")), HasSubstr("default-src 'none'")));
  EXPECT_THAT(first, HasSubstr("The ray was traced again in s.ply"));
  EXPECT_THAT(page("--pixel 8,8"), HasSubstr("made from the trace alone"));
  const json said = json::parse(folder_.run("ray t.grtx --pixel 8,8 --json -o r.html").out);
  EXPECT_EQ(said.at("schema"), "grtx.ray/1");
  EXPECT_EQ(said.at("rays"), 1);
  EXPECT_FALSE(said.at("traced_again").get<bool>());
}

TEST_F(Ray, TakesTheTracesViewFromItsName) {
  make("--view 2 --accel tlas-tri20 --checkpoint on");
  EXPECT_NE(page("--pixel 8,8 " + kScene), "");
  ASSERT_TRUE(std::filesystem::remove(folder_.path("r.html")));
  expect_refused("t.grtx --pixel 8,8 --view 1 -o r.html " + kScene, "is not traced as in t.grtx");
}

TEST_F(Ray, TakesRoundsFromATimeline) {
  make("--accel tlas-tri20 --checkpoint on");
  ASSERT_EQ(folder_.run("sim t.grtx --machine paper --timeline t.json --quiet").code, 0);
  const json shown = description(page("--pixel 8,8 --timeline t.json"));
  const json& rounds = shown.at("rays")[0].at("rounds");
  std::size_t found = 0, activities = 0;
  std::uint64_t end = 0;
  for (const json& slice : shown.at("warps")[0].at("timeline")) {
    EXPECT_LE(slice[2], slice[3]);
    if (slice[0] != "") {
      ++activities;
      continue;
    }
    EXPECT_EQ(slice[1], found++);
    EXPECT_GE(slice[2], end);
    end = slice[3];
  }
  EXPECT_GE(found, rounds.size());  // the warp's longest ray may have more
  EXPECT_GT(activities, found);
  ASSERT_TRUE(std::filesystem::remove(folder_.path("r.html")));

  ASSERT_EQ(folder_.run(kTrace + "--accel tri20 -o u.grtx").code, 0);
  expect_refused("u.grtx --pixel 8,8 --timeline t.json -o r.html", "t.json: trace: is the timeline of another trace");
  expect_refused("t.grtx --pixel 8,8 --timeline s.cameras.json -o r.html", "s.cameras.json: is no timeline");
  folder_.write("cut.json", folder_.read("t.json").substr(0, 2000));
  expect_refused("t.grtx --pixel 8,8 --timeline cut.json -o r.html", "cut.json: byte");
  ASSERT_EQ(folder_.run("sim t.grtx --machine paper --timeline w.json --timeline-window 1:2 --quiet").code, 0);
  expect_refused("t.grtx --warp 7 --timeline w.json -o r.html", "does not show warp 7");
}

// "is not valid JSON" of the picture that `grtx sim --timeline t.svg` had written.
TEST_F(Ray, ATimelineOfAnotherFormatIsCalledWhatItIs) {
  make("--accel tri20");
  for (const auto& [file, what] : {std::pair("t.svg", "a picture"), std::pair("t.pftrace", "Perfetto's protobuf")}) {
    ASSERT_EQ(folder_.run(std::string("sim t.grtx --machine paper --quiet --timeline ") + file).code, 0);
    expect_refused(std::string("t.grtx --pixel 8,8 -o r.html --timeline ") + file,
                   fmt::format("{}: is {}: 'grtx sim --timeline T.json' writes what can be read", file, what));
  }
}

// A file t.png was JSON.
TEST_F(Ray, ATimelineOfAnUnknownEndingIsRefusedWhereItIsMade) {
  make("--accel tri20");
  const Outcome outcome = folder_.run("sim t.grtx --machine paper --quiet --timeline t.png");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_EQ(outcome.err, "grtx: t.png: a timeline's name must end in .pftrace, .json or .svg\n");
  EXPECT_FALSE(folder_.has("t.png") || folder_.has("t.png.partial"));
}

TEST_F(Ray, IsRefusedInOneLine) {
  make("--accel tlas-tri20 --checkpoint on");
  expect_refused("t.grtx -o r.html", "--pixel");
  expect_refused("t.grtx --pixel 8,8 --warp 1 -o r.html", "--warp");
  expect_refused("t.grtx --pixel 8 -o r.html", "--pixel");
  expect_refused("t.grtx --pixel 16,8 -o r.html", "t.grtx: --pixel 16,8: the image has 16 x 16 pixels");
  expect_refused("t.grtx --warp 8 -o r.html", "t.grtx: --warp 8: the trace has 8 warps");
  expect_refused("t.grtx --pixel 8,8 --frame 1 -o r.html", "t.grtx: --frame 1: the trace has 1 frame");
  expect_refused("t.grtx --pixel 8,8 --scene s.ply -o r.html", "--cameras");
  expect_refused("t.grtx --pixel 8,8 --cameras s.cameras.json -o r.html", "--scene");
  expect_refused("missing.grtx --pixel 8,8 -o r.html", "missing.grtx");
  expect_refused("s.ply --pixel 8,8 -o r.html", "s.ply");
  expect_refused("t.grtx --pixel 8,8 -o no_such_folder/r.html", "no_such_folder");
  expect_refused("t.grtx --pixel 8,8 --width 8 -o r.html " + kScene, "the trace has 16 x 16");
  ASSERT_EQ(folder_.run("synth --preset object --count 2000 --seed 8 --sh-degree 1 -o u.ply --quiet").code, 0);
  expect_refused("t.grtx --pixel 8,8 --scene u.ply --cameras s.cameras.json -o r.html",
                 "u.ply: scene: is not that of the trace");
  const std::string trace = folder_.read("t.grtx");
  expect_refused("t.grtx --pixel 8,8 -o t.grtx", "is an input, too, and would be lost");
  expect_refused("t.grtx --pixel 8,8 -o s.ply " + kScene, "is an input, too, and would be lost");
  EXPECT_EQ(folder_.read("t.grtx"), trace);
}

}  // namespace
}  // namespace grtx::e2e
