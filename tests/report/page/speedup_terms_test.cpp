// SPDX-License-Identifier: Apache-2.0
// A speed-up taken apart: its terms multiply to the whole, and a term alone explains what it alone changes.
#include "grtx/report/page/speedup_terms.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

namespace grtx::report {
namespace {

using Values = std::map<std::string, double>;

StatisticValue value_of(const Values& values) {
  return [values](const std::string& name) { return values.contains(name) ? values.at(name) : std::nan(""); };
}

/// 1,000 visits in 800 fetches of 100 cycles, two of which are under way at a time in a warp; 500 instructions of 8
/// cycles, and 6,000 cycles of waits for memory; 8 warps.
Values one() {
  return {{"gpu.rt.node_visits", 1000},          {"gpu.rt.node_fetches", 800},
          {"gpu.rt.node_fetch_latency", 100},    {"gpu.simt.instructions.total", 500},
          {"gpu.cycles", 50000.0 / 8},           {"gpu.simt.resident_warp_cycles", 50000},
          {"gpu.simt.warp_cycles.trace", 40000}, {"gpu.simt.warp_cycles.fetch", 0},
          {"gpu.simt.warp_cycles.memory", 5000}, {"gpu.simt.warp_cycles.drain", 1000}};
}

TEST(SpeedupTerms, MultiplyToTheWhole) {
  Values other = one();
  other["gpu.rt.node_visits"] = 300;
  other["gpu.rt.node_fetches"] = 200;
  other["gpu.rt.node_fetch_latency"] = 70;
  other["gpu.simt.instructions.total"] = 100;
  other["gpu.simt.warp_cycles.trace"] = 9000;
  other["gpu.simt.warp_cycles.memory"] = 1000;
  other["gpu.simt.resident_warp_cycles"] = 12000;
  other["gpu.cycles"] = 2000;
  const std::vector<SpeedupTerm> terms = speedup_terms(value_of(one()), value_of(other));
  ASSERT_EQ(terms.size(), 8U);
  double product = 1.0;
  for (const SpeedupTerm& term : terms) product *= term.factor;
  EXPECT_DOUBLE_EQ(product, 50000.0 / 8 / 2000);
  EXPECT_DOUBLE_EQ(terms.back().cycles, 2000);
  EXPECT_EQ(terms.front().name, "visits");
  EXPECT_DOUBLE_EQ(terms.front().cycles,
                   (0.3 * 40000 + 10000) / 8);  // three tenths of the traversal, all of the shaders
  EXPECT_DOUBLE_EQ(terms[3].cycles, (40000 * 200.0 / 800 * 0.7 + 800 + 6000) / 8);
  EXPECT_TRUE(terms.back().name.starts_with("residual"));
}

TEST(SpeedupTerms, ATermThatAloneChangesIsTheWholeSpeedUp) {
  Values other = one();
  other["gpu.rt.node_fetch_latency"] = 50;
  other["gpu.simt.warp_cycles.trace"] = 20000;
  other["gpu.simt.resident_warp_cycles"] = 30000;
  other["gpu.cycles"] = 30000.0 / 8;
  for (const SpeedupTerm& term : speedup_terms(value_of(one()), value_of(other))) {
    EXPECT_DOUBLE_EQ(term.factor, term.name == "latency of a fetch" ? 50.0 / 30 : 1.0) << term.name;
  }
}

TEST(SpeedupTerms, NeedAllTheirStatistics) {
  Values lacking = one();
  lacking.erase("gpu.rt.node_visits");
  EXPECT_TRUE(speedup_terms(value_of(one()), value_of(lacking)).empty());
  EXPECT_TRUE(speedup_terms(value_of(lacking), value_of(one())).empty());
}

}  // namespace
}  // namespace grtx::report
