// SPDX-License-Identifier: Apache-2.0
// gpu.energy_nj: its parts add up to it in whole picojoules, and rays share it.
#include "grtx/explore/cost/energy_statistics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "grtx/base/child_process.h"
#include "grtx/rtl_tlm/run/simulation.h"
#include "rtl_tlm/simulate_priced.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::explore {
namespace {

std::int64_t picojoules(const nlohmann::json& stats, const std::string& name) {
  const double pj = stats.at(name).at("value").get<double>() * 1e3;
  EXPECT_NEAR(pj, std::round(pj), 1e-4) << name;
  return std::llround(pj);
}

TEST(EnergyStatistics, PartsAddUpAndRaysShareThem) {
  traces::testing::RandomOptions random{.groups = 4, .warp_size = 32, .two_level = true};
  const traces::testing::TemporaryFile file("energy_statistics");
  auto trace = traces::testing::random_trace(random);
  std::uint64_t rays = 0;
  for (const traces::RayGroup& group : trace.groups) rays += group.rays.size();
  traces::testing::write_trace(file.path(), trace.header, trace.groups);
  ChildProcess child("simulation", [&] {
    return sim::test::simulate_priced(file.path(), sim::load_config("", {}), {}).document.at("stats").dump();
  });
  const auto stats = nlohmann::json::parse(child.result());

  const std::int64_t total = picojoules(stats, "gpu.energy_nj");
  std::int64_t sum = 0;
  for (const char* part : {"rt", "simt", "l1", "crossbar", "l2", "dram", "leakage"}) {
    const std::int64_t pj = picojoules(stats, std::string("gpu.energy_nj.") + part);
    EXPECT_GT(pj, 0) << part;
    sum += pj;
  }
  EXPECT_EQ(sum, total);
  EXPECT_LT(picojoules(stats, "gpu.energy_nj_low"), total);
  EXPECT_GT(picojoules(stats, "gpu.energy_nj_high"), total);
  ASSERT_GT(rays, 0U);
  EXPECT_EQ(stats.at("gpu.energy_nj_per_ray").at("value").get<double>(),
            stats.at("gpu.energy_nj").at("value").get<double>() / static_cast<double>(rays));
  // DRAM, as an example by hand: 7.5 pJ per bit.
  EXPECT_EQ(picojoules(stats, "gpu.energy_nj.dram"), 60 * stats.at("gpu.dram.bytes").at("value").get<std::int64_t>());
}

}  // namespace
}  // namespace grtx::explore
