// SPDX-License-Identifier: Apache-2.0
// examples/own_policy: three policies that are told what they decide about, each by its key.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include "grtx/rtl_tlm/run/statistics_json.h"
#include "paths.h"
#include "rtl_tlm/observe/observed_run.h"

namespace grtx::sim {
namespace {

constexpr const char* kSmallCaches =
    "--set gpu.sms=3 --set l1.bytes=2048 --set l1.ways=4 --set l2.slices=2 --set l2.bytes=4096 ";

class OwnPolicy : public ::testing::Test {
 protected:
  nlohmann::ordered_json simulated(const std::string& settings) const {
    const std::string output = run_.path("output");
    const std::string command = "'" + grtx::paths::own_policy() + "' sim '" + run_.path("t.grtx") +
                                "' --quiet --stats '" + run_.path("s.json") + "' " + kSmallCaches + settings + " > '" +
                                output + "' 2>&1";
    const int status = std::system(command.c_str());
    std::ifstream file(output);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    EXPECT_EQ(status, 0) << text;
    EXPECT_EQ(text.find("SystemC"), std::string::npos)
        << "a program of one's own printed the kernel's banner: " << text;
    return read_statistics(run_.path("s.json"));
  }
  test::ObservedRun run_{true, true};
};

TEST_F(OwnPolicy, EachMovesWhatItDecides) {
  const auto plain = simulated("");
  const auto cycles = [](const auto& run) { return test::statistic(run.at("stats"), "gpu.cycles"); };
  EXPECT_NE(cycles(simulated("--set rt.scheduler.policy=fullest")), cycles(plain));
  const auto blocks = simulated("--set gpu.distribution=blocks");
  EXPECT_EQ(blocks.at("config").at("gpu.distribution"), "blocks");
  EXPECT_NE(cycles(blocks), cycles(plain));
  EXPECT_EQ(test::statistic(blocks.at("stats"), "gpu.distributor.groups"),
            test::statistic(plain.at("stats"), "gpu.distributor.groups"));
}

// A factory is told sizes alone, and each value of a parameter took a name: srrip1, srrip2, srrip3.
TEST_F(OwnPolicy, AParameterTakesNoNamePerValue) {
  const auto eights = simulated("--set gpu.distribution=blocks");
  const auto pairs = simulated("--set gpu.distribution=blocks --set gpu.blocks.groups=2");
  EXPECT_EQ(eights.at("config").at("gpu.blocks.groups"), 8);
  EXPECT_EQ(pairs.at("config").at("gpu.blocks.groups"), 2);
  EXPECT_NE(test::statistic(pairs.at("stats"), "gpu.cycles"), test::statistic(eights.at("stats"), "gpu.cycles"));
}

TEST_F(OwnPolicy, NodesStayInTheL2WhereThePolicySeesThem) {
  const auto misses = [](const auto& run) {
    std::uint64_t all = 0;
    for (const char* region : {"tlas", "blas", "leaf", "instance"}) {
      const std::string name = std::string("gpu.l2.") + region + ".misses";
      if (run.at("stats").contains(name)) all += test::statistic(run.at("stats"), name);
    }
    return all;
  };
  const std::uint64_t lru = misses(simulated("--set l2.replacement=lru"));
  const std::uint64_t kept = misses(simulated("--set l2.replacement=keep_nodes"));
  EXPECT_GT(lru, 0u);
  EXPECT_LT(kept, lru / 2);
}

TEST_F(OwnPolicy, TakesNinetyLines) {
  std::ifstream file(grtx::paths::source_dir() + "/examples/own_policy.cpp");
  EXPECT_LE(std::count(std::istreambuf_iterator<char>(file), {}, '\n'), 1 + 90) << "beside its licence line";
}

}  // namespace
}  // namespace grtx::sim
