// SPDX-License-Identifier: Apache-2.0
// Pages of grtx ray in a real browser: ray_browser.mjs steps through them, this says what must be there.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/browser.h"

namespace grtx::e2e {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

/// Gaussians of a list of hits.
std::vector<int> ids(const json& hits) {
  std::vector<int> found;
  for (const json& hit : hits) found.push_back(hit[0].get<int>());
  return found;
}

class RayInBrowser : public InBrowser {
 protected:
  RayInBrowser() : InBrowser("ray_browser.mjs") {}

  void make(const std::string& page, const std::string& trace, const std::string& ray) {
    const Outcome traced = folder.run("trace --quiet -o t.grtx " + trace);
    ASSERT_EQ(traced.code, 0) << traced.err;
    const Outcome made = folder.run("ray t.grtx --quiet -o " + page + " " + ray);
    ASSERT_EQ(made.code, 0) << made.err;
  }

  void expect_sound(const json& found) {
    EXPECT_THAT(found.at("messages"), IsEmpty()) << found.at("messages");
    EXPECT_THAT(found.at("requests"), IsEmpty()) << found.at("requests");
    EXPECT_LE(found.at("overflow").at("1280").get<int>(), 0);
    EXPECT_LE(found.at("overflow").at("390").get<int>(), 0);
    EXPECT_NE(found.at("light"), found.at("dark"));
    for (const char* fault : {"repeated_ids", "cut_rows", "cut_tables", "cut_heads"}) {
      EXPECT_THAT(found.at(fault), IsEmpty()) << fault << ": " << found.at(fault);
    }
    EXPECT_TRUE(found.at("labelled").get<bool>());
    EXPECT_THAT(found.at("home").get<std::string>(), StartsWith("round 0 of"));
    EXPECT_THAT(found.at("home").get<std::string>(), HasSubstr("event –"));
    EXPECT_THAT(found.at("opened").at("where").get<std::string>(), StartsWith("round 0 of"));  // at its end
    EXPECT_THAT(found.at("opened").at("text").get<std::string>(), HasSubstr("The round is over"));
    EXPECT_THAT(found.at("story").get<std::string>(), HasSubstr("times the frame's median"));
    EXPECT_THAT(found.at("second").get<std::string>(), HasSubstr("event 1 of"));
    EXPECT_THAT(found.at("back").get<std::string>(), HasSubstr("event 0 of"));
    EXPECT_EQ(found.at("small"), found.at("hits")[4].at("where"));
    EXPECT_EQ(found.at("after_turning"), found.at("hits")[4].at("where"));
    EXPECT_FALSE(found.at("playing").get<bool>());
    EXPECT_THAT(found.at("find_nothing").at("where").get<std::string>(), HasSubstr("has no event about it"));
    EXPECT_THAT(found.at("find_node").at("text").get<std::string>(), HasSubstr("0x"));
    EXPECT_EQ(found.at("unfolded"), 0);
    EXPECT_LT(found.at("elements").get<int>(), 4000);
    EXPECT_EQ(found.at("plain").at("note"), 1);
    // What a round leaves is what the next one begins with.
    const json& rounds = found.at("rounds");
    for (std::size_t r = 0; r + 1 < rounds.size(); ++r) {
      const json& end = rounds[r].at("end");
      const json& begin = rounds[r + 1].at("begin");
      EXPECT_EQ(end.at("sizes").at("stack"), "0");
      EXPECT_THAT(end.at("text").get<std::string>(), HasSubstr("The round is over"));
      const auto written = end.at("sizes").at("destination").get<std::string>();
      EXPECT_EQ(begin.at("sizes").at("source"), written + " of " + written) << "round " << r;
    }
  }
};

// docs/model/walkthrough.md
TEST_F(RayInBrowser, TheWalkthroughIsSteppedThrough) {
  const std::string data = grtx::paths::source_dir() + "/data/walkthrough/";
  const std::string scene = "--scene " + data + "scene.ply --cameras " + data + "cameras.json ";
  make("walkthrough.html", scene + "--accel tlas-sphere --checkpoint on --k 4 --child-order near_first", "--pixel 0,0");
  ASSERT_EQ(folder.run("sim t.grtx --machine paper --timeline t.json --quiet").code, 0);
  ASSERT_EQ(folder.run("ray t.grtx --pixel 0,0 --timeline t.json --quiet -o walkthrough.html " + scene).code, 0);
  const json found = look("walkthrough.html");
  ASSERT_TRUE(found.contains("plain"));
  expect_sound(found);
  EXPECT_THAT(found.at("story").get<std::string>(), HasSubstr("took 3 rounds"));
  EXPECT_THAT(found.at("story").get<std::string>(), HasSubstr("All rounds but the first went on from checkpoints"));
  EXPECT_THAT(found.at("pixel").get<std::string>(), HasSubstr("pixel 0,0 of"));
  ASSERT_FALSE(found.at("along").is_null());
  EXPECT_THAT(found.at("first_hit").at("text").get<std::string>(), StartsWith("Gaussian 12 at t = "));  // the nearest
  EXPECT_THAT(found.at("first_hit").at("state").at("text").get<std::string>(), HasSubstr("Gaussian 12 at t = "));
  EXPECT_THAT(ids(found.at("hits")[3].at("k_buffer")), testing::ElementsAre(12, 7, 21, 33));
  EXPECT_NEAR(found.at("hits")[3].at("k_buffer")[3][1].get<double>(), 2.85, 5e-5);
  EXPECT_TRUE(found.at("hits")[3].at("t_max").is_null());  // infinite
  const json& rejected = found.at("hits")[4];
  EXPECT_THAT(rejected.at("text").get<std::string>(), HasSubstr("Gaussian 5 at t = 3.2, rejected"));
  EXPECT_THAT(rejected.at("text").get<std::string>(), HasSubstr("∞ → 3.2"));
  EXPECT_THAT(ids(rejected.at("k_buffer")), testing::ElementsAre(12, 7, 21, 33));
  EXPECT_THAT(ids(rejected.at("evictions")), testing::ElementsAre(5));
  EXPECT_NEAR(rejected.at("t_max").get<double>(), 3.2, 5e-5);

  const json& rounds = found.at("rounds");
  ASSERT_EQ(rounds.size(), 3u);
  EXPECT_EQ(rounds[0].at("end").at("destination").size(), 4u);
  EXPECT_EQ(rounds[1].at("begin").at("source"), rounds[0].at("end").at("destination"));
  EXPECT_THAT(ids(rounds[1].at("begin").at("k_buffer")), testing::ElementsAre(5));
  EXPECT_THAT(ids(rounds[1].at("end").at("k_buffer")), testing::ElementsAre(5, 18, 2, 29));
  EXPECT_EQ(rounds[1].at("end").at("taken"), 3);  // the fourth is read by the round's last event
  EXPECT_EQ(rounds[2].at("begin").at("source").size(), 1u);
  EXPECT_THAT(ids(rounds[2].at("end").at("k_buffer")), testing::ElementsAre(9, 14, 26));

  EXPECT_FALSE(found.at("view").is_null());
  EXPECT_NE(found.at("view"), found.at("turned"));
  EXPECT_FALSE(found.at("axis").is_null());
  // A short round was a line of a few pixels between the first and the last cycle of the warp.
  const json& labels = found.at("axis_labels");
  EXPECT_NE(labels[1], labels[0]);
  EXPECT_EQ(labels[2], labels[0]);
  EXPECT_FALSE(found.at("axis_near").is_null());
  EXPECT_NE(found.at("axis_near"), found.at("axis"));
  EXPECT_THAT(found.at("find_gaussian").at("where").get<std::string>(), HasSubstr("2 events about 12"));
  EXPECT_THAT(found.at("down").get<std::string>(), HasSubstr("round 0 of 0–2, event 1 of"));
  EXPECT_EQ(found.at("plain").at("rows"), 3);
}

// Events come in the order in which the ray came to them, and nodes under way keep their place on the stack.
TEST_F(RayInBrowser, AWalkIsSteppedThrough) {
  ASSERT_EQ(folder.run("synth --preset object --count 2000 --seed 7 -o s.ply --quiet").code, 0);
  make("walk.html",
       "--scene s.ply --cameras s.cameras.json --width 16 --height 16 --accel ellipsoid --layout quantised --k 4 "
       "--ahead 8",
       "--pixel 8,8 --scene s.ply --cameras s.cameras.json");
  const json found = look("walk.html");
  ASSERT_TRUE(found.contains("plain"));
  EXPECT_THAT(found.at("messages"), IsEmpty()) << found.at("messages");
  const json& rounds = found.at("rounds");
  ASSERT_GT(rounds.size(), 1u);
  for (const json& round : rounds) {
    EXPECT_EQ(round.at("end").at("sizes").at("stack"), "0, 0 under way");
    EXPECT_EQ(round.at("begin").at("sizes").at("stack"), "1, 1 under way");
  }
  for (std::size_t r = 0; r + 1 < rounds.size(); ++r) {  // a round that is not the last fills the k-buffer
    EXPECT_EQ(rounds[r].at("end").at("k_buffer").size(), 4u) << "round " << r;
  }
  EXPECT_THAT(found.at("hits")[0].at("sizes").at("stack").get<std::string>(), HasSubstr("under way"));
  // Distances are those of the tracer: the k-buffer is sorted, and t_max is finite once a hit was rejected.
  for (const json& round : rounds) {
    const json& hits = round.at("end").at("k_buffer");
    for (std::size_t i = 0; i + 1 < hits.size(); ++i) EXPECT_LE(hits[i][1].get<double>(), hits[i + 1][1].get<double>());
  }
  EXPECT_FALSE(rounds[0].at("end").at("t_max").is_null());
}

TEST_F(RayInBrowser, WithoutTheSceneListsAreThereAndTimesAreNot) {
  ASSERT_EQ(folder.run("synth --preset object --count 2000 --seed 7 -o s.ply --quiet").code, 0);
  make("alone.html",
       "--scene s.ply --cameras s.cameras.json --width 16 --height 16 --accel tlas-tri20 --checkpoint on --k 4",
       "--pixel 8,8");
  const json found = look("alone.html");
  ASSERT_TRUE(found.contains("plain"));
  expect_sound(found);
  EXPECT_TRUE(found.at("view").is_null());
  EXPECT_TRUE(found.at("axis").is_null());
  EXPECT_TRUE(found.at("along").is_null());
  EXPECT_THAT(found.at("story").get<std::string>(), HasSubstr("hits, of which"));
  EXPECT_GT(found.at("folds").get<int>(), 0);
  EXPECT_THAT(found.at("first").at("text").get<std::string>(), HasSubstr("t_max: not in the trace"));
  EXPECT_EQ(found.at("hits")[3].at("k_buffer").size(), 4u);
  for (const json& round : found.at("rounds")) EXPECT_LE(round.at("end").at("k_buffer").size(), 4u);
}

TEST_F(RayInBrowser, AMillionEventsAreShownByRowsInSight) {
  // A row of Gaussians that all overlap: a round per hit, and each visits those before it again.
  constexpr unsigned kGaussians = 1300;
  std::string ply = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(kGaussians) + "\n";
  for (const char* name : {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
                           "rot_0", "rot_1", "rot_2", "rot_3"}) {
    ply += std::string("property float ") + name + "\n";
  }
  ply += "end_header\n";
  for (unsigned i = 0; i < kGaussians; ++i)
    ply += "0 0 " + std::to_string(10 + 1e-3 * i) + " 0 0 0 -3 -1 -1 -1 1 0 0 0\n";
  folder.write("s.ply", ply);
  folder.write("s.cameras.json", R"([{"id": 0, "img_name": "a", "width": 2, "height": 2, "position": [0, 0, 0],)"
                                 R"( "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "fx": 100, "fy": 100}])");
  const std::string scene = "--scene s.ply --cameras s.cameras.json ";
  make("million.html", scene + "--accel ellipsoid --tracing closest --ert 0", "--pixel 1,1 " + scene);
  const json said = json::parse(folder.run("ray t.grtx --pixel 1,1 --json -o again.html").out);
  EXPECT_GT(said.at("events").get<int>(), 1000000);
  const json found = look("million.html");
  ASSERT_TRUE(found.contains("plain"));
  expect_sound(found);
  EXPECT_LE(found.at("columns").get<int>(), 5);
  EXPECT_EQ(found.at("plain").at("rows"), said.at("rounds"));
}

}  // namespace
}  // namespace grtx::e2e
