// SPDX-License-Identifier: Apache-2.0
// Layout quantised: traces of scenes without outliers stay what they are, byte for byte.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "apps/program.h"

namespace grtx::e2e {
namespace {

TEST(QuantisedBytes, ScenesWithoutOutliersKeepTheirTraces) {
  Folder folder;
  ASSERT_EQ(folder.run("synth --quiet --preset building --count 2000 --seed 3 -o s.ply").code, 0);
  // As of the release before there were wide leaves.
  for (const auto& [accel, hash] :
       {std::pair{"ellipsoid", "be7c27c6583eadfc"}, std::pair{"tlas-tri20", "5ce7c56b4ad370db"}}) {
    const std::string accel_name = accel;
    ASSERT_EQ(folder
                  .run("trace --quiet --scene s.ply --cameras s.cameras.json --width 16 --height 16 --layout quantised "
                       "-o t.grtx --stats t.json --accel " +
                       accel_name)
                  .code,
              0);
    const std::string dump = folder.run("trace-dump --json t.grtx").out;
    const nlohmann::json first = nlohmann::json::parse(dump.substr(0, dump.find('\n')));
    EXPECT_EQ(first.at("content_hash"), hash) << accel_name;
    const nlohmann::json statistics = nlohmann::json::parse(folder.read("t.json"));
    EXPECT_EQ(statistics.at("stats").at("accel.nodes.wide").at("value"), 0) << accel_name;
  }
}

}  // namespace
}  // namespace grtx::e2e
