// SPDX-License-Identifier: Apache-2.0
// Rank correlation by hand, and what two modes say of the same points.
#include "grtx/report/page/mode_agreement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace grtx::report {
namespace {

TEST(KendallTau, OfOrdersThatCanBeCounted) {
  EXPECT_DOUBLE_EQ(kendall_tau({1, 2, 3, 4}, {10, 20, 30, 40}), 1.0);
  EXPECT_DOUBLE_EQ(kendall_tau({1, 2, 3, 4}, {4, 3, 2, 1}), -1.0);
  EXPECT_DOUBLE_EQ(kendall_tau({1, 2, 3, 4}, {1, 2, 4, 3}), 4.0 / 6.0);             // five pairs agree, one does not
  EXPECT_DOUBLE_EQ(kendall_tau({1, 1, 2}, {1, 2, 3}), 2.0 / std::sqrt(2.0 * 3.0));  // a tie in the first
  EXPECT_DOUBLE_EQ(kendall_tau({1, 1, 2}, {5, 5, 7}), 1.0);                         // the same tie in both
  EXPECT_TRUE(std::isnan(kendall_tau({1, 1, 1}, {1, 2, 3})));
  EXPECT_TRUE(std::isnan(kendall_tau({}, {})));
}

TEST(KendallTau, DoesNotDependOnTheOrderOfThePointsNorOnTheScale) {
  std::mt19937_64 random(26);
  std::vector<double> a, b;
  for (int i = 0; i < 40; ++i) {
    a.push_back(static_cast<double>(random() % 20));
    b.push_back(a.back() + static_cast<double>(random() % 9));
  }
  const double tau = kendall_tau(a, b);
  EXPECT_GT(tau, 0.3);
  EXPECT_LT(tau, 1.0);
  EXPECT_DOUBLE_EQ(kendall_tau(b, a), tau);
  EXPECT_DOUBLE_EQ(kendall_tau({a.rbegin(), a.rend()}, {b.rbegin(), b.rend()}), tau);
  std::vector<double> grown;
  for (const double x : b) grown.push_back(std::exp(0.1 * x));
  EXPECT_DOUBLE_EQ(kendall_tau(a, grown), tau);
}

ReportedPoint point(const char* scene, const char* mode, int entries, double time, const char* status = "done") {
  ReportedPoint p;
  p.mode = mode;
  p.scene = scene;
  p.design = "grtx";
  p.coordinates = {{"rt.warp_buffer.entries", entries}};
  p.status = status;
  p.values["gpu.time_us"] = time;
  return p;
}

TEST(ModeAgreement, ComparesPointsOfTheSameSceneDesignAndCoordinates) {
  SweepResults sweep;
  sweep.points = {point("room", "windows", 1, 110.0), point("room", "windows", 2, 60.0),
                  point("room", "windows", 4, 50.0),  point("room", "windows", 8, 40.0),
                  point("room", "cycle", 4, 50.0),    point("room", "cycle", 1, 100.0),
                  point("room", "cycle", 2, 48.0),    point("hall", "cycle", 1, 9.0),
                  point("hall", "windows", 1, 9.0),   point("room", "cycle", 8, 1.0, "failed")};
  const std::vector<ModeAgreement> list = mode_agreements(sweep);
  ASSERT_EQ(list.size(), 1u);  // one point says nothing of a ranking
  EXPECT_EQ(list[0].scene, "room");
  EXPECT_EQ(list[0].mode, "windows");
  EXPECT_EQ(list[0].against, "cycle");
  EXPECT_EQ(list[0].points, 3u);
  EXPECT_DOUBLE_EQ(list[0].least_ratio, 1.0);
  EXPECT_DOUBLE_EQ(list[0].largest_ratio, 1.25);
  EXPECT_NEAR(list[0].mean_ratio, std::cbrt(1.1 * 1.25), 1e-12);
  EXPECT_DOUBLE_EQ(list[0].tau, 1.0 / 3.0);  // 2 and 4 entries change places
}

}  // namespace
}  // namespace grtx::report
