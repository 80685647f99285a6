// Groups are dealt out to classes of equal make-up: each group once, by lot, the same for every design.
#include "grtx/rtl_tlm/estimate/sampled/sampler.h"
#include "parameter_names.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

namespace grtx::sim {
namespace {

/// Groups with `processed` entries like i^2 mod 101, and costs that follow them.
std::vector<GroupWork> some_groups(std::size_t count) {
  std::vector<GroupWork> groups(count);
  for (std::size_t i = 0; i < count; ++i) {
    groups[i].processed = i * i % 101;
    groups[i].sectors = 10.0 * static_cast<double>(groups[i].processed) + static_cast<double>(i % 7);
  }
  return groups;
}

struct Dealing {
  std::size_t groups;
  unsigned classes;
  friend void PrintTo(const Dealing& d, std::ostream* out) {
    *out << d.groups << " groups " << d.classes << " classes";
  }
};
class Sampler : public ::testing::TestWithParam<Dealing> {};

TEST_P(Sampler, DealsEveryGroupOnceInAscendingOrder) {
  const auto classes = deal_classes(some_groups(GetParam().groups), GetParam().classes, 3);
  ASSERT_EQ(classes.size(), GetParam().classes);
  std::multiset<std::uint64_t> seen;
  for (const auto& one : classes) {
    EXPECT_TRUE(std::is_sorted(one.begin(), one.end()));
    seen.insert(one.begin(), one.end());
    EXPECT_LE(one.size(), GetParam().groups / GetParam().classes + 1);
    EXPECT_GE(one.size() + 1, (GetParam().groups + GetParam().classes - 1) / GetParam().classes);
  }
  std::vector<std::uint64_t> expected(GetParam().groups);
  std::iota(expected.begin(), expected.end(), std::uint64_t{0});
  EXPECT_TRUE(std::equal(seen.begin(), seen.end(), expected.begin(), expected.end()));
}

INSTANTIATE_TEST_SUITE_P(Sizes, Sampler,
                         ::testing::Values(Dealing{512, 32}, Dealing{513, 32}, Dealing{31, 32}, Dealing{1, 2},
                                           Dealing{100, 7}),
                         grtx::test::PrintedName{});

TEST(SamplerTest, ClassTotalsTimesClassesAreUnbiasedOverSeeds) {
  constexpr unsigned kClasses = 8;
  constexpr unsigned kSeeds = 400;
  const std::vector<GroupWork> groups = some_groups(203);  // the last stratum is not full
  double total = 0.0;
  for (const GroupWork& group : groups) total += group.sectors;
  double mean = 0.0;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const auto classes = deal_classes(groups, kClasses, seed);
    for (const std::uint64_t i : classes.front()) mean += groups[i].sectors * kClasses / kSeeds;
  }
  EXPECT_NEAR(mean / total, 1.0, 0.01);  // its deviation is about 0.002
}

TEST(SamplerTest, ClassesAreMuchMoreAlikeThanRandomOnes) {
  const std::vector<GroupWork> groups = some_groups(512);
  double total = 0.0;
  for (const GroupWork& group : groups) total += group.sectors;
  for (const auto& one : deal_classes(groups, 16, 1)) {
    double sum = 0.0;
    for (const std::uint64_t i : one) sum += groups[i].sectors;
    EXPECT_NEAR(16.0 * sum / total, 1.0, 0.08);  // 32 groups drawn freely: a deviation of 0.1
  }
}

TEST(SamplerTest, SeedsDecideAndCostsOfADesignDoNot) {
  std::vector<GroupWork> groups = some_groups(100);
  const auto classes = deal_classes(groups, 8, 5);
  EXPECT_NE(classes, deal_classes(groups, 8, 6));
  for (GroupWork& group : groups) group.sectors = group.far = group.steps = 1.0;
  EXPECT_EQ(classes, deal_classes(groups, 8, 5));
}

TEST(SamplerTest, GivesTheSameClassesOnEveryMachine) {
  const auto classes = deal_classes(some_groups(8), 4, 1);
  const auto again = deal_classes(some_groups(8), 4, 1);
  EXPECT_EQ(classes, again);
  std::size_t all = 0;
  for (const auto& one : classes) all += one.size();
  EXPECT_EQ(all, 8U);
}

}  // namespace
}  // namespace grtx::sim
