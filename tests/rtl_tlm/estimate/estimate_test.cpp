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
  return {.log_cycles = std::log(cycles),
          .drift = 0.01,
          .evidence = {{3, 0.02, 0.004}, {8, -0.03, 0.002 * sign}, {11, 0.01, -0.001}, {17, 0.01, 0.001}}};
}

TEST(CyclesInterval, AddsUpItsTerms) {
  const CycleEstimate e = some_estimate(1e6, 1.0);
  const ConfidenceInterval interval = cycles_interval(e);
  // By hand: influences 4, 2, -1, 1 thousandths, so steps of 2, 3, 2; four windows are three pairs.
  const double variance = 4.0 / (2.0 * 3.0) * (4.0 + 9.0 + 4.0) * 1e-6 + 0.01 * 0.01;
  EXPECT_NEAR(interval.deviation, std::sqrt(variance), 1e-12);
  const double reach = student_quantile(0.975, 2.0) * std::sqrt(variance);  // two thirds of three
  EXPECT_NEAR(interval.low, 1e6 * std::exp(-reach), 2.0);
  EXPECT_NEAR(interval.high, 1e6 * std::exp(reach), 2.0);
  EXPECT_NEAR(interval.half_width, std::exp(reach) - 1.0, 1e-6);
}

TEST(CyclesInterval, DoesNotTakeAChangeAlongTheFrameForNoise) {
  CycleEstimate slow, rough;
  for (std::uint64_t i = 0; i < 40; ++i) {
    const double influence = 0.001 * std::sin(0.1 * static_cast<double>(i));
    slow.evidence.push_back({i, 0.0, influence});
    rough.evidence.push_back({i, 0.0, i % 2 == 0 ? influence : -influence});
  }
  EXPECT_LT(cycles_interval(slow).deviation, 0.1 * cycles_interval(rough).deviation);
}

TEST(RatioInterval, CancelsWhatPairsHaveInCommon) {
  const CycleEstimate base = some_estimate(3e6, 1.0);
  CycleEstimate other = some_estimate(1e6, 1.0);
  const ConfidenceInterval paired = ratio_interval(base, other);
  EXPECT_NEAR(paired.value, 3.0, 1e-12);
  EXPECT_NEAR(paired.deviation, 0.0, 1e-12);
  for (GroupEvidence& e : other.evidence) e.group += 100;  // other windows: nothing cancels
  EXPECT_NEAR(ratio_interval(base, other).deviation, std::sqrt(2.0) * cycles_interval(base).deviation, 1e-12);
}

TEST(RatioInterval, DiffersWhereTheWindowsDo) {
  const CycleEstimate base = some_estimate(3e6, 1.0);
  CycleEstimate other = some_estimate(1e6, -1.0);
  other.drift = 0.004;
  const double variance = 4.0 / (2.0 * 3.0) * (16.0 + 16.0) * 1e-6 + 0.006 * 0.006;
  EXPECT_NEAR(ratio_interval(base, other).deviation, std::sqrt(variance), 1e-12);
}

TEST(RatioInterval, AWholeRunAddsNothing) {
  CycleEstimate base = some_estimate(3e6, 1.0);
  CycleEstimate other = some_estimate(1e6, 1.0);
  other.whole = true;
  other.evidence.clear();
  EXPECT_NEAR(ratio_interval(base, other).deviation, cycles_interval(base).deviation, 1e-12);
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
