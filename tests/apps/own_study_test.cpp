// SPDX-License-Identifier: Apache-2.0
// examples/own_experiment does what `grtx run` does.
#include <gtest/gtest.h>

#include <cstdlib>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/program.h"
#include "paths.h"

namespace grtx::e2e {
namespace {

/// results.json without what depends on the host.
nlohmann::json results_of(const Folder& folder, const std::string& name) {
  nlohmann::json results = nlohmann::json::parse(folder.read(name + "/results.json"));
  for (auto& [design, statistics] : results.at("designs").items()) {
    for (const char* of_host :
         {"host.", "tracer.wall", "tracer.rays_per", "tracer.visits_per", "accel.build", "accel.pack"}) {
      for (auto item = statistics.begin(); item != statistics.end();) {
        item = item.key().starts_with(of_host) ? statistics.erase(item) : std::next(item);
      }
    }
  }
  return results;
}

TEST(OwnStudy, GivesWhatTheProgramGives) {
  const Folder folder;
  ASSERT_EQ(folder.run("synth --preset object --count 2000 --seed 3 -o s.ply --quiet").code, 0);
  const Outcome program = folder.run(
      "run --scene s.ply --cameras s.cameras.json --width 32 --height 32 --machine paper-charged --set "
      "gpu.sms=2 -o program --json --quiet");
  ASSERT_EQ(program.code, 0) << program.err;
  const std::string own =
      "cd '" + folder.path() + "' && '" + paths::own_experiment() + "' s.ply s.cameras.json own >.own 2>&1";
  ASSERT_EQ(std::system(own.c_str()), 0) << folder.read(".own");
  const nlohmann::json expected = results_of(folder, "program");
  EXPECT_EQ(results_of(folder, "own"), expected);
  EXPECT_EQ(folder.read("own/image.png"), folder.read("program/image.png"));
  const double speedup = expected.at("speedup").at("grtx").get<double>();
  EXPECT_NE(folder.read(".own").find(fmt::format("grtx over baseline: {:.3f}\n", speedup)), std::string::npos);
}

// One process each, and one folder: the second finds what the first left.
TEST(OwnStudy, GivesTheSameWhenLaunchedTwice) {
  const Folder folder;
  ASSERT_EQ(folder.run("synth --preset room --count 1500 --seed 4 -o s.ply --quiet").code, 0);
  const std::string own =
      "cd '" + folder.path() + "' && '" + paths::own_experiment() + "' s.ply s.cameras.json own >.own 2>&1";
  ASSERT_EQ(std::system(own.c_str()), 0) << folder.read(".own");
  const nlohmann::json first = results_of(folder, "own");
  const std::string said = folder.read(".own");
  const std::string image = folder.read("own/image.png");
  ASSERT_EQ(std::system(own.c_str()), 0) << folder.read(".own");
  EXPECT_EQ(results_of(folder, "own"), first);
  EXPECT_EQ(folder.read(".own"), said);
  EXPECT_EQ(folder.read("own/image.png"), image);
}

TEST(OwnStudy, RefusesInOneLineWhatItCannotRun) {
  const Folder folder;
  const std::string own =
      "cd '" + folder.path() + "' && '" + paths::own_experiment() + "' none.ply none.json own >.own 2>&1";
  EXPECT_EQ(WEXITSTATUS(std::system(own.c_str())), 2);
  EXPECT_NE(folder.read(".own").find("none.json"), std::string::npos) << folder.read(".own");
}

}  // namespace
}  // namespace grtx::e2e
