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
  EXPECT_NEAR(product, 50000.0 / 8 / 2000, 1e-12);
  EXPECT_NEAR(terms.back().cycles, 2000, 1e-9);
  EXPECT_EQ(terms.front().name, "visits");
  EXPECT_TRUE(terms.back().name.starts_with("residual"));
}

/// A design whose traversal and waits each take a fifth.
Values quicker() {
  Values other = one();
  other["gpu.rt.node_visits"] = 200;
  other["gpu.rt.node_fetches"] = 160;
  other["gpu.simt.warp_cycles.trace"] = 8000;
  other["gpu.simt.warp_cycles.memory"] = 200;
  other["gpu.simt.resident_warp_cycles"] = 13200;
  other["gpu.cycles"] = 13200.0 / 8;
  return other;
}

// Of two terms the one that was exchanged last had the large factor: waits 15 times, visits 2.4, of a run in which
// visits save most cycles.
TEST(SpeedupTerms, DoNotDependOnTheOrderInWhichTheyAreExchanged) {
  const std::vector<SpeedupTerm> there = speedup_terms(value_of(one()), value_of(quicker()));
  const std::vector<SpeedupTerm> back = speedup_terms(value_of(quicker()), value_of(one()));
  ASSERT_EQ(there.size(), back.size());
  for (std::size_t i = 0; i < there.size(); ++i) EXPECT_NEAR(there[i].factor * back[i].factor, 1.0, 1e-12) << i;
  // Two terms: the mean of what each takes as the first and as the last (50,000, 18,000, 45,200 and 13,200 cycles).
  EXPECT_NEAR(there[0].factor, std::sqrt(50.0 / 18.0 * 45.2 / 13.2), 1e-9);
  EXPECT_NEAR(there[4].factor, std::sqrt(50.0 / 45.2 * 18.0 / 13.2), 1e-9);
}

TEST(SpeedupTerms, ATermThatAloneChangesIsTheWholeSpeedUp) {
  Values other = one();
  other["gpu.rt.node_fetch_latency"] = 50;
  other["gpu.simt.warp_cycles.trace"] = 20000;
  other["gpu.simt.resident_warp_cycles"] = 30000;
  other["gpu.cycles"] = 30000.0 / 8;
  for (const SpeedupTerm& term : speedup_terms(value_of(one()), value_of(other))) {
    EXPECT_NEAR(term.factor, term.name == "latency of a fetch" ? 50.0 / 30 : 1.0, 1e-12) << term.name;
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
