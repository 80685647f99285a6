// SPDX-License-Identifier: Apache-2.0
// Single-round, list and closest-hit tracing: the same image and blended Gaussians as multi-round tracing, bit for bit,
// and the work that each mode stands for.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "frontend/synth/stress_scenes.h"
#include "frontend/tracer/random_scene.h"
#include "frontend/tracer/render_helpers.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/reference/reference.h"
#include "grtx/frontend/tracer/k_buffer.h"

namespace grtx::frontend {
namespace {

constexpr AccelKind kAllKinds[] = {AccelKind::tri20,      AccelKind::tri80,      AccelKind::ellipsoid,
                                   AccelKind::tlas_tri20, AccelKind::tlas_tri80, AccelKind::tlas_sphere};

void expect_modes_agree(const Scene& scene, const Camera& camera, AccelKind kind, TracerOptions options) {
  const PreparedGaussians gaussians(scene, true);
  const AccelerationStructure accel(gaussians, {kind, 6, false});
  const RenderResult expected = test::trace_scene(scene, camera, accel, gaussians, options);
  ASSERT_GT(expected.counters.blended, 100u);
  const auto expect_same = [&](const std::string& what) {
    const RenderResult actual = test::trace_scene(scene, camera, accel, gaussians, options);
    EXPECT_EQ(compare(expected.image, actual.image).different_pixels, 0u) << accel_name(kind) << " " << what;
    EXPECT_TRUE(expected.sequences == actual.sequences) << accel_name(kind) << " " << what;
    EXPECT_EQ(expected.counters.blended, actual.counters.blended) << what;
    EXPECT_EQ(expected.counters.processed, actual.counters.processed) << what;
    EXPECT_EQ(expected.counters.terminated, actual.counters.terminated) << what;
  };
  for (const ChildOrder order : {ChildOrder::near_first, ChildOrder::slot, ChildOrder::vulkan_sim}) {
    options.child_order = order;
    options.pop_test = order == ChildOrder::slot ? PopTest::on : PopTest::off;
    for (const Tracing tracing : {Tracing::single, Tracing::list}) {
      options.tracing = tracing;
      for (const unsigned k : {1u, 2u, 3u, 16u, 100u, kMaxK}) {  // the small ones run full
        for (const TmaxUpdate update : {TmaxUpdate::reported, TmaxUpdate::kth}) {
          options.k = k;
          options.tmax_update = update;
          expect_same(std::string(name_of(tracing)) + " k " + std::to_string(k));
        }
      }
    }
    options.tracing = Tracing::closest;
    options.k = 1;
    expect_same("closest");
  }
}

TEST(TracingModes, AgreeOnRandomScenes) {
  for (const AccelKind kind : kAllKinds) {
    expect_modes_agree(test::random_scene(31, {60, 0.8, -1.8, 1.0, 0.02, 0.95, 1}), test::front_camera(10, 8), kind,
                       {});
  }
}

TEST(TracingModes, AgreeOnTies) {
  const test::GeneratedScene ties = test::generated_scene("stress-ties", 1500);
  for (const AccelKind kind : {AccelKind::tri20, AccelKind::tlas_sphere}) {
    expect_modes_agree(ties.scene, test::small_view(ties, 0, 16), kind, {});
  }
}

TEST(TracingModes, AgreeOnPeakKeys) {
  TracerOptions options;
  options.sort_key = SortKey::peak;
  for (const AccelKind kind : {AccelKind::tri20, AccelKind::tlas_sphere}) {
    expect_modes_agree(test::random_scene(32, {80, 0.8, -1.8, 1.0, 0.02, 0.95, 1}), test::front_camera(12, 8), kind,
                       options);
  }
}

TEST(TracingModes, SingleTakesOneRoundUnlessItsBufferRunsFull) {
  const Scene scene = test::random_scene(33);
  const Camera camera = test::front_camera(24, 24);
  TracerOptions options;
  options.k = kMaxK;
  options.tracing = Tracing::single;
  const TracerCounters large = test::trace_scene(scene, camera, AccelKind::tri20, options).counters;
  EXPECT_EQ(large.rounds, large.rays);
  EXPECT_EQ(large.single_overflows, 0u);
  EXPECT_EQ(large.any_hit_calls(), large.any_hit_inserted);
  options.ert = 0.0f;
  const TracerCounters all = test::trace_scene(scene, camera, AccelKind::tri20, options).counters;
  EXPECT_GT(all.blended, large.blended);
  EXPECT_EQ(all.visits(), large.visits()) << "the end of a ray saves blending, not traversal";
  options.ert = TracerOptions{}.ert;
  options.k = 8;
  const TracerCounters small = test::trace_scene(scene, camera, AccelKind::tri20, options).counters;
  EXPECT_GT(small.single_overflows, 0u);
  EXPECT_GT(small.rounds, small.rays);
  // Each overflow costs a further round unless the ray ends by early termination.
  EXPECT_LE(small.single_overflows, small.rounds - small.rays + small.terminated);
  EXPECT_GT(small.any_hit_evicted, 0u);
}

TEST(TracingModes, AListThatHoldsAllIsOneTraversal) {
  const Scene scene = test::random_scene(33);
  const Camera camera = test::front_camera(24, 24);
  TracerOptions options;
  options.tracing = Tracing::list;
  options.k = options.list_capacity = kMaxK;
  const TracerCounters whole = test::trace_scene(scene, camera, AccelKind::tlas_box, options).counters;
  EXPECT_EQ(whole.rounds, whole.rays);
  EXPECT_EQ(whole.single_overflows, 0u);
  EXPECT_EQ(whole.any_hit_calls(), whole.any_hit_inserted) << "each hit is written once";
  options.ert = 0.0f;
  const TracerCounters all = test::trace_scene(scene, camera, AccelKind::tlas_box, options).counters;
  EXPECT_EQ(all.visits(), whole.visits()) << "the end of a ray saves blending, not traversal";
  EXPECT_EQ(all.processed, all.any_hit_inserted);
  options.k = options.list_capacity = 8;
  const TracerCounters small = test::trace_scene(scene, camera, AccelKind::tlas_box, options).counters;
  EXPECT_GT(small.single_overflows, 0u);
  EXPECT_GT(small.rounds, small.rays);
  EXPECT_EQ(small.processed, all.processed) << "a further pass finds what did not fit";
  EXPECT_EQ(small.blended, all.blended);
}

// A list that overflows loses nothing of the image of the fp64 reference, which has no rounds.
TEST(TracingModes, ListsGiveTheImageOfTheReference) {
  const Scene scene = test::random_scene(35, {200, 0.8, -1.8, 1.0, 0.02, 0.95, 1});
  const Camera camera = test::front_camera(20, 16);
  ReferenceOptions exact;
  exact.proxy = ReferenceProxy::sphere;
  const Image expected = render_reference(scene, camera, exact).image;
  TracerOptions options;
  options.tracing = Tracing::list;
  for (const unsigned capacity : {4u, 64u, kMaxK}) {
    options.k = options.list_capacity = capacity;
    const RenderResult traced = test::trace_scene(scene, camera, AccelKind::tlas_box, options);
    EXPECT_GT(compare(expected, traced.image).psnr, 100.0) << "capacity " << capacity;
  }
}

TEST(TracingModes, ClosestTakesARoundForEachHit) {
  const Scene scene = test::random_scene(34);
  TracerOptions options;
  options.k = 1;
  options.tracing = Tracing::closest;
  for (const AccelKind kind : kAllKinds) {
    const TracerCounters c = test::trace_scene(scene, test::front_camera(16, 16), kind, options).counters;
    EXPECT_EQ(c.rounds, c.processed + c.rays - c.terminated) << accel_name(kind);
    EXPECT_EQ(c.any_hit_calls(), 0u);
    EXPECT_GE(c.nearest_commits, c.processed);
    EXPECT_EQ(c.any_hit_evicted, 0u);
  }
}

// A k-buffer used as a heap holds the k smallest and counts the moves within the bounds that trace-check relies on.
TEST(KBufferHeap, KeepsTheSmallest) {
  std::mt19937 random(5);
  for (const unsigned k : {1u, 2u, 7u, 64u, 2048u}) {
    unsigned levels = 0;
    while ((2u << levels) <= k) ++levels;
    KBuffer buffer(k, false);
    std::vector<KEntry> all;
    for (std::uint32_t i = 0; i < 3 * k; ++i) {
      const KEntry e{static_cast<float>(random() % (k + 2)), i, 0.0f};
      all.push_back(e);
      if (!buffer.full()) {
        const unsigned moved = buffer.insert(e);
        EXPECT_LT(moved, k);
        EXPECT_TRUE(moved == 0 || buffer.full());
      } else if (e < buffer.last()) {
        EXPECT_LE(buffer.replace_last(e), levels);
      }
    }
    buffer.sort();
    std::sort(all.begin(), all.end());
    for (unsigned i = 0; i < k; ++i) EXPECT_EQ(buffer.entries()[i].id, all[i].id) << "k " << k << " entry " << i;
  }
}

}  // namespace
}  // namespace grtx::frontend
