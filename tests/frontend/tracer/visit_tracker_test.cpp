// SPDX-License-Identifier: Apache-2.0
// Distinct nodes of a ray and of a view, against sets.
#include "grtx/frontend/tracer/visit_tracker.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace grtx::frontend {
namespace {

TEST(VisitTrackerTest, CountsWhatSetsCountWhateverTheLengthOfARay) {
  constexpr std::uint32_t kUnits = 60'000;
  const NodeImage image(6, std::uint64_t{kUnits} * traces::kNodeUnit);
  Footprint footprint(image);
  VisitTracker one(footprint), other(footprint);  // as two threads have them
  std::mt19937 random(7);
  std::set<std::uint32_t> touched;
  std::uint64_t unique = 0;
  for (const unsigned visits : {0U, 10U, 50'000U, 3'000U, 200'000U, 10U}) {  // the table grows on the way
    for (VisitTracker* tracker : {&one, &other}) {
      tracker->begin_ray();
      std::set<std::uint32_t> of_ray;
      for (unsigned i = 0; i < visits; ++i) {
        const auto unit = static_cast<std::uint32_t>(random() % (kUnits / 2) * 2);
        const unsigned size = unit % 4 == 0 ? 2 : 1;
        tracker->visit(unit, size);
        of_ray.insert(unit);
        for (unsigned u = 0; u < size; ++u) touched.insert(unit + u);
      }
      unique += of_ray.size();
    }
  }
  EXPECT_EQ(one.unique() + other.unique(), unique);
  EXPECT_EQ(footprint.bytes(), touched.size() * traces::kNodeUnit);
}

}  // namespace
}  // namespace grtx::frontend
