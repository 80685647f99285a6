// SPDX-License-Identifier: Apache-2.0
// Intervals: Student's quantiles, and the variances against a second, plain implementation.
#include "grtx/rtl_tlm/estimate/estimate.h"

#include <gtest/gtest.h>

#include <cmath>

namespace grtx::sim {
namespace {

TEST(StudentQuantile, IsThatOfTheTables) {
  const struct {
    double p, degrees, quantile;
  } rows[] = {{0.975, 1, 12.7062},  {0.975, 2, 4.30265}, {0.975, 5, 2.57058}, {0.95, 10, 1.81246},
              {0.975, 30, 2.04227}, {0.995, 4, 4.60409}, {0.5, 3, 0.0}};
  for (const auto& row : rows)
    EXPECT_NEAR(student_quantile(row.p, row.degrees), row.quantile, 1e-4 * row.quantile + 1e-9);
  EXPECT_NEAR(student_quantile(0.975, 1e6), 1.95996, 1e-4);
  EXPECT_NEAR(student_quantile(0.025, 5), -2.57058, 1e-4);
}

CycleEstimate some_estimate(double cycles, double sign) {
  CycleEstimate e{.log_cycles = std::log(cycles),
                  .degrees_of_freedom = 6.0,
                  .bias = {0.09, 0.16},
                  .evidence = {{3, 0.02, 0.004}, {8, -0.03, 0.002 * sign}, {11, 0.01, -0.001}}};
  return e;
}

TEST(CyclesInterval, AddsUpItsTerms) {
  CycleEstimate e = some_estimate(1e6, 1.0);
  e.bias.cycles = 0.005;
  const ConfidenceInterval interval = cycles_interval(e);
  // By hand: influences 4, 2, 1 thousandths; 8 / 6 for few windows.
  const double variance = 8.0 / 6.0 * (16.0 + 4.0 + 1.0) * 1e-6 + 0.005 * 0.005;
  EXPECT_NEAR(interval.deviation, std::sqrt(variance), 1e-12);
  // Welch and Satterthwaite: 6 degrees for the windows, e.bias.degrees for the bias.
  const double samples = variance - 0.005 * 0.005;
  const double degrees = variance * variance / (samples * samples / 6.0 + std::pow(0.005, 4) / e.bias.degrees);
  const double reach = student_quantile(0.975, degrees) * std::sqrt(variance);
  EXPECT_NEAR(interval.low, 1e6 * std::exp(-reach), 2.0);
  EXPECT_NEAR(interval.high, 1e6 * std::exp(reach), 2.0);
  EXPECT_NEAR(interval.half_width, std::exp(reach) - 1.0, 1e-6);
}

TEST(CyclesInterval, IsNeverNarrowerForWindowsThatScatterMore) {
  CycleEstimate e;
  e.bias.cycles = 0.09;
  e.degrees_of_freedom = 20.0;
  double narrowest = 0.0;
  for (double scatter = 0.0; scatter < 0.3; scatter += 0.005) {
    e.evidence = {{1, 0.0, scatter}};
    const double width = cycles_interval(e).half_width;
    EXPECT_GE(width, narrowest) << scatter;
    narrowest = width;
  }
  EXPECT_GT(narrowest, 0.5);
}

TEST(RatioInterval, CancelsWhatPairsHaveInCommon) {
  const CycleEstimate base = some_estimate(3e6, 1.0);
  CycleEstimate other = some_estimate(1e6, 1.0);
  const ConfidenceInterval paired = ratio_interval(base, other);
  EXPECT_NEAR(paired.value, 3.0, 1e-12);
  EXPECT_NEAR(paired.deviation, 0.16, 1e-12) << "only the bias is left";
  for (GroupEvidence& e : other.evidence) e.group += 100;  // other windows: nothing cancels
  EXPECT_NEAR(ratio_interval(base, other).deviation, std::sqrt(2.0 * 8.0 / 6.0 * 21e-6 + 0.16 * 0.16), 1e-12);
}

TEST(RatioInterval, DiffersWhereTheWindowsDo) {
  const CycleEstimate base = some_estimate(3e6, 1.0), other = some_estimate(1e6, -1.0);
  const double variance = 8.0 / 6.0 * std::pow(0.002 + 0.002, 2) + 0.16 * 0.16;
  EXPECT_NEAR(ratio_interval(base, other).deviation, std::sqrt(variance), 1e-12);
}

TEST(CyclesInterval, ASmallerBiasMakesItNarrower) {
  CycleEstimate e = some_estimate(1e6, 1.0);
  const double wide = cycles_interval(e).half_width;
  e.bias = {0.012, 0.02};
  EXPECT_LT(cycles_interval(e).half_width, 0.6 * wide);
  e.evidence.clear();  // windows without scatter: the bias alone, with its own few degrees
  EXPECT_NEAR(cycles_interval(e).half_width, std::expm1(student_quantile(0.975, e.bias.degrees) * e.bias.cycles), 1e-9);
}

TEST(RatioInterval, AWholeRunAddsNoBias) {
  CycleEstimate base = some_estimate(3e6, 1.0);
  CycleEstimate other = some_estimate(1e6, 1.0);
  other.whole = true;
  other.evidence.clear();
  EXPECT_NEAR(ratio_interval(base, other).deviation, cycles_interval(base).deviation, 1e-3);
}

TEST(WholeRun, HasNoWidth) {
  CycleEstimate e = some_estimate(5e5, 1.0);
  e.whole = true;
  EXPECT_EQ(cycles_interval(e).half_width, 0.0);
  EXPECT_EQ(cycles_interval(e).low, cycles_interval(e).high);
  EXPECT_EQ(ratio_interval(e, e).deviation, 0.0);
}

TEST(Estimate, SurvivesJson) {
  const CycleEstimate e = some_estimate(123456.0, -1.0);
  const CycleEstimate read = estimate_from_json(nlohmann::ordered_json::parse(to_json(e).dump()));
  EXPECT_EQ(cycles_interval(read).low, cycles_interval(e).low);
  EXPECT_EQ(read.evidence.size(), e.evidence.size());
  EXPECT_EQ(ratio_interval(read, e).value, 1.0);
}

}  // namespace
}  // namespace grtx::sim
