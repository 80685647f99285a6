// SPDX-License-Identifier: Apache-2.0
// Delayed any-hit shaders, and early termination that is tested once per round: what they change in image and work, and
// what they must not change.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "frontend/synth/stress_scenes.h"
#include "frontend/tracer/random_scene.h"
#include "frontend/tracer/render_helpers.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/tracer/secondary_plan.h"

namespace grtx::frontend {
namespace {

constexpr AccelKind kDelayedKinds[] = {AccelKind::tri20,   AccelKind::tri80,      AccelKind::ellipsoid,
                                       AccelKind::box,     AccelKind::tlas_tri20, AccelKind::tlas_sphere,
                                       AccelKind::tlas_box};

struct View {
  std::string name;
  Scene scene;
  Camera camera;
};

std::vector<View> views() {
  std::vector<View> all;
  all.push_back({"mixed", test::random_scene(11, {60, 0.8, -1.8, 1.0, 0.02, 0.95, 2}), test::front_camera(8, 8)});
  all.push_back({"opaque", test::random_scene(12, {60, 0.8, -1.8, 0.5, 0.9, 1.0, 0}), test::front_camera(8, 8, 3.0)});
  all.push_back({"inside", test::random_scene(13, {60, 0.8, -1.2, 0.8, 0.05, 0.5, 1}), test::front_camera(8, 8, 0.2)});
  for (const char* preset : {"hall", "object", "stress-ties", "stress-copies"}) {
    const test::GeneratedScene generated = test::generated_scene(preset, preset[0] == 's' ? 80 : 300, 0);
    all.push_back({preset, generated.scene, test::small_view(generated, 0, 8)});
  }
  return all;
}

void expect_same_image(const RenderResult& expected, const RenderResult& actual, const std::string& what) {
  EXPECT_TRUE(compare(expected.image, actual.image).identical()) << what;
  EXPECT_TRUE(expected.sequences == actual.sequences) << what;
  EXPECT_EQ(expected.counters.rounds, actual.counters.rounds) << what;
  EXPECT_EQ(expected.counters.processed, actual.counters.processed) << what;
  EXPECT_EQ(expected.counters.blended, actual.counters.blended) << what;
  EXPECT_EQ(expected.counters.terminated, actual.counters.terminated) << what;
}

/// Calls visit(options, name) for sort keys, t_max updates, sizes and orders.
template <typename Visit>
void for_each_setting(Visit&& visit) {
  unsigned variant = 0;
  for (const SortKey key : {SortKey::entry, SortKey::peak}) {
    for (const TmaxUpdate update : {TmaxUpdate::reported, TmaxUpdate::kth}) {
      for (const unsigned k : {1u, 3u, 16u, 64u}) {
        TracerOptions options;
        options.sort_key = key;
        options.tmax_update = update;
        options.k = k;
        options.child_order = static_cast<ChildOrder>(variant % 3);
        options.pop_test = variant % 2 == 0 ? PopTest::on : PopTest::off;
        ++variant;
        visit(options, std::string(name_of(key)) + " " + std::string(name_of(update)) + " k " + std::to_string(k));
      }
    }
  }
}

TEST(DelayedAnyHit, GivesTheImageAndTheRoundsOfImmediateShaders) {
  for (const View& view : views()) {
    const PreparedGaussians gaussians(view.scene, true);
    for (const AccelKind kind : kDelayedKinds) {
      const AccelerationStructure accel(gaussians, {kind, 6, false});
      for_each_setting([&](TracerOptions options, const std::string& setting) {
        const std::string what = view.name + " " + accel_name(kind) + " " + setting;
        const RenderResult immediate = test::trace_scene(view.scene, view.camera, accel, gaussians, options);
        options.any_hit = AnyHit::delayed;
        const RenderResult delayed = test::trace_scene(view.scene, view.camera, accel, gaussians, options);
        expect_same_image(immediate, delayed, what);
        EXPECT_GE(delayed.counters.visits(), immediate.counters.visits()) << what;
        EXPECT_GE(delayed.counters.any_hit_calls(), immediate.counters.any_hit_calls()) << what;
      });
      if (HasFailure()) return;
    }
  }
}

TEST(DelayedAnyHit, LosesTheTiesThatStrictResumeLoses) {
  const test::GeneratedScene generated = test::generated_scene("stress-copies", 100, 0);
  const Camera camera = test::small_view(generated, 0, 8);
  TracerOptions options;
  options.k = 4;
  options.resume = Resume::strict;
  const RenderResult immediate = test::trace_scene(generated.scene, camera, AccelKind::tlas_tri20, options);
  options.any_hit = AnyHit::delayed;
  const RenderResult delayed = test::trace_scene(generated.scene, camera, AccelKind::tlas_tri20, options);
  expect_same_image(immediate, delayed, "strict");
  EXPECT_GT(delayed.counters.ties_lost, 0u);
}

// t_max is the same in all rounds and t_min only grows, so a round visits what the first one visits, or less; and
// neither the order of children nor the update of t_max nor the test of popped nodes changes how much.
TEST(DelayedAnyHit, TheWorkDependsOnNeitherOrderNorUpdateNorPopTest) {
  const Scene scene = test::random_scene(11);
  const Camera camera = test::front_camera(16, 16);
  TracerOptions options;
  options.any_hit = AnyHit::delayed;
  options.k = 4;
  const TracerCounters first = test::trace_scene(scene, camera, AccelKind::tlas_tri20, options).counters;
  EXPECT_GT(first.any_hit_evicted, 0u);
  for (const ChildOrder order : {ChildOrder::near_first, ChildOrder::slot, ChildOrder::vulkan_sim}) {
    for (const TmaxUpdate update : {TmaxUpdate::reported, TmaxUpdate::kth}) {
      for (const PopTest test : {PopTest::on, PopTest::off}) {
        options.child_order = order;
        options.tmax_update = update;
        options.pop_test = test;
        const TracerCounters other = test::trace_scene(scene, camera, AccelKind::tlas_tri20, options).counters;
        EXPECT_EQ(other.visits(), first.visits());
        EXPECT_EQ(other.any_hit_calls(), first.any_hit_calls());
      }
    }
  }
}

TEST(ErtCheck, OnceARoundBlendsTheRestOfTheRoundThatEndsTheRay) {
  for (const View& view : views()) {
    const PreparedGaussians gaussians(view.scene, true);
    const AccelerationStructure accel(gaussians, {AccelKind::ellipsoid, 6, false});
    for (const unsigned k : {1u, 4u, 16u}) {
      TracerOptions options;
      options.k = k;
      options.ert = 0.05f;
      const RenderResult by_hit = test::trace_scene(view.scene, view.camera, accel, gaussians, options);
      options.ert_check = ErtCheck::round;
      const RenderResult by_round = test::trace_scene(view.scene, view.camera, accel, gaussians, options);
      options.ert = 0.0f;
      const RenderResult whole = test::trace_scene(view.scene, view.camera, accel, gaussians, options);
      const std::string what = view.name + " k " + std::to_string(k);
      EXPECT_EQ(by_round.counters.rounds, by_hit.counters.rounds) << what << ": a ray ends in the same round";
      EXPECT_EQ(by_round.counters.visits(), by_hit.counters.visits()) << what;
      EXPECT_EQ(by_round.counters.terminated, by_hit.counters.terminated) << what;
      EXPECT_GE(by_round.counters.processed, by_hit.counters.processed) << what;
      if (k == 1) expect_same_image(by_hit, by_round, what);
      for (std::size_t pixel = 0; pixel < by_hit.sequences.size(); ++pixel) {
        const auto &few = by_hit.sequences[pixel], &more = by_round.sequences[pixel], &all = whole.sequences[pixel];
        ASSERT_LE(few.size(), more.size()) << what;
        ASSERT_LT(more.size() - few.size(), k) << what;
        ASSERT_LE(more.size(), all.size()) << what;
        EXPECT_TRUE(std::equal(few.begin(), few.end(), more.begin())) << what;
        EXPECT_TRUE(std::equal(more.begin(), more.end(), all.begin())) << what;
      }
    }
  }
}

TEST(ErtCheck, OnceARoundMakesTheImageDependOnK) {
  const Scene scene = test::random_scene(12, {60, 0.8, -1.8, 0.5, 0.9, 1.0, 0});
  const Camera camera = test::front_camera(16, 16, 3.0);
  TracerOptions options;
  options.ert = 0.1f;
  options.ert_check = ErtCheck::round;
  options.k = 1;
  const RenderResult one = test::trace_scene(scene, camera, AccelKind::tri20, options);
  options.k = 8;
  const RenderResult eight = test::trace_scene(scene, camera, AccelKind::tri20, options);
  EXPECT_FALSE(compare(one.image, eight.image).identical());
  EXPECT_GT(eight.counters.blended, one.counters.blended);
}

// With one k the image still depends on nothing else: structure, checkpointing, orders, and when any-hit shaders run.
TEST(ErtCheck, OnceARoundGivesOneImageForOneK) {
  const Scene scene = test::random_scene(12, {60, 0.8, -1.8, 0.5, 0.5, 1.0, 0});
  const Camera camera = test::front_camera(12, 12, 3.0);
  TracerOptions options;
  options.ert = 0.05f;
  options.ert_check = ErtCheck::round;
  options.k = 4;
  const RenderResult expected = test::trace_scene(scene, camera, AccelKind::tri20, options);
  EXPECT_GT(expected.counters.terminated, 0u);
  for (const AccelKind kind : {AccelKind::tri20, AccelKind::tlas_tri20}) {
    for (const unsigned variant : {0u, 1u, 2u, 3u}) {
      TracerOptions other = options;
      other.checkpoint = variant == 1 || variant == 2;
      other.checkpoint_capacity = variant == 2 ? 3 : 1024;
      other.any_hit = variant == 3 ? AnyHit::delayed : AnyHit::immediate;
      other.child_order = ChildOrder::slot;
      other.tmax_update = TmaxUpdate::kth;
      const RenderResult result = test::trace_scene(scene, camera, kind, other);
      EXPECT_TRUE(compare(expected.image, result.image).identical()) << accel_name(kind) << " " << variant;
      EXPECT_TRUE(expected.sequences == result.sequences) << accel_name(kind) << " " << variant;
    }
  }
}

TEST(ErtCheck, ARoundOfOneHitOrOfAllIsTestedAsItsNameSays) {
  const Scene scene = test::random_scene(12, {60, 0.8, -1.8, 0.5, 0.9, 1.0, 0});
  const Camera camera = test::front_camera(12, 12, 3.0);
  TracerOptions options;
  options.ert = 0.1f;
  options.ert_check = ErtCheck::round;
  options.tracing = Tracing::closest;
  options.k = 1;
  TracerOptions by_hit = options;
  by_hit.ert_check = ErtCheck::hit;
  expect_same_image(test::trace_scene(scene, camera, AccelKind::tri20, by_hit),
                    test::trace_scene(scene, camera, AccelKind::tri20, options), "closest");
  options.tracing = by_hit.tracing = Tracing::single;
  options.k = by_hit.k = kMaxK;
  by_hit.ert = 0.0f;  // the only round has all hits
  EXPECT_TRUE(compare(test::trace_scene(scene, camera, AccelKind::tri20, by_hit).image,
                      test::trace_scene(scene, camera, AccelKind::tri20, options).image)
                  .identical());
}

}  // namespace
}  // namespace grtx::frontend
