// SPDX-License-Identifier: Apache-2.0
// Secondary rays in the tracer: the first invariant, agreement with the reference, limits, groups, counters.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <set>

#include "frontend/tracer/random_scene.h"
#include "frontend/tracer/render_helpers.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/reference/reference.h"
#include "grtx/frontend/tracer/light_path.h"
#include "grtx/frontend/tracer/secondary_plan.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/traces/check.h"
#include "grtx/traces/reader.h"
#include "grtx/traces/writer.h"
#include "temporary_folder.h"

namespace grtx::frontend {
namespace {

struct Traced {
  SecondaryPlan plan;
  RenderResult result;
};

Traced trace_with(const OpticalObjects& objects, const Scene& scene, const Camera& camera,
                  const PreparedGaussians& gaussians, const AccelerationStructure& accel, const TracerOptions& options,
                  unsigned threads, const std::string& trace_file) {
  Traced traced;
  traced.plan = plan_secondary(scene, gaussians, accel, camera, options, objects, false, threads);
  RenderOptions render{.threads = threads, .keep_sequences = true, .secondary = &traced.plan};
  if (trace_file.empty()) {
    traced.result = frontend::render(scene, gaussians, accel, camera, options, render, nullptr);
  } else {
    traces::Writer writer(trace_file, trace_header(scene, camera, accel, options, render));
    traced.result = frontend::render(scene, gaussians, accel, camera, options, render, &writer);
    writer.finish();
  }
  return traced;
}

Traced trace_with(const OpticalObjects& objects, const Scene& scene, const Camera& camera, AccelKind kind,
                  const TracerOptions& options, unsigned threads = 1, const std::string& trace_file = "") {
  const PreparedGaussians gaussians(scene, options.kernel);
  const AccelerationStructure accel(gaussians, {kind, 6, false});
  return trace_with(objects, scene, camera, gaussians, accel, options, threads, trace_file);
}

/// Glass left and mirror right before a scene that surrounds the camera, so that mirrored light finds something.
Scene surroundings() {
  return test::random_scene(17, {.count = 900, .extent = 4.0, .log_scale_mean = -1.6, .log_scale_sd = 0.6});
}
Camera camera(unsigned width = 32, unsigned height = 24) { return test::front_camera(width, height, 1.0); }
OpticalObjects both() {
  OpticalObjects objects{.glass = make_glass({-0.45, 0.05, 0.6}, 0.42, 1.5),
                         .mirror = make_mirror({0.5, 0.0, 0.7}, {-0.4, 0.1, -1.0}, 0.8, 0.9)};
  return objects;
}

TEST(SecondaryRays, EverySettingGivesTheSameImage) {
  const Scene scene = surroundings();
  const Camera view = camera(16, 12);
  const PreparedGaussians gaussians(scene, true);
  TracerOptions options;
  const Traced expected = trace_with(both(), scene, view, AccelKind::tri20, options);
  ASSERT_GT(expected.result.secondary.rays, 40u);
  ASSERT_GT(expected.result.secondary.blended, 300u);
  for (const AccelKind kind : {AccelKind::tri20, AccelKind::tlas_tri20}) {
    const AccelerationStructure accel(gaussians, {kind, 6, false});
    for (const unsigned k : {1u, 8u, 64u}) {
      for (const unsigned capacity : {0u, 3u, 1024u}) {  // 0: no checkpointing
        for (const TmaxUpdate update : {TmaxUpdate::reported, TmaxUpdate::kth}) {
          options = TracerOptions{};
          options.k = k;
          options.checkpoint = capacity > 0;
          options.checkpoint_capacity = std::max(capacity, 1u);
          options.tmax_update = update;
          options.replay_tmax = update == TmaxUpdate::kth ? ReplayTmax::kth : ReplayTmax::infinity;
          options.child_order = enum_names(ChildOrder{})[(k + capacity) % 3].value;
          options.pop_test = (k + capacity / 2) % 2 == 0 ? PopTest::off : PopTest::on;
          const Traced actual = trace_with(both(), scene, view, gaussians, accel, options, 1, "");
          EXPECT_TRUE(compare(expected.result.image, actual.result.image).identical())
              << accel_name(kind) << " k " << k << " capacity " << capacity;
          EXPECT_EQ(expected.result.sequences, actual.result.sequences);
          EXPECT_EQ(expected.plan.rays.size(), actual.plan.rays.size());
        }
      }
    }
  }
}

// Primary rays end at the objects, where what lies beyond is beyond in every round.
TEST(SecondaryRays, DelayedAnyHitShadersGiveTheSameImageAndSoundTraces) {
  const test::TemporaryFolder folder;
  const Scene scene = surroundings();
  TracerOptions options;
  options.k = 4;
  for (const AccelKind kind : {AccelKind::tri20, AccelKind::tlas_sphere}) {
    for (const PopTest pop_test : {PopTest::on, PopTest::off}) {
      options.pop_test = pop_test;
      options.any_hit = AnyHit::immediate;
      const Traced immediate = trace_with(both(), scene, camera(16, 12), kind, options);
      options.any_hit = AnyHit::delayed;
      const std::string file = folder.path() + "/delayed.grtx";
      const Traced delayed = trace_with(both(), scene, camera(16, 12), kind, options, 1, file);
      EXPECT_TRUE(compare(immediate.result.image, delayed.result.image).identical()) << accel_name(kind);
      EXPECT_TRUE(immediate.result.sequences == delayed.result.sequences) << accel_name(kind);
      EXPECT_GT(delayed.result.secondary.rays, 40u);
      const traces::Reader reader(file);
      EXPECT_EQ(reader.header().any_hit, AnyHit::delayed);
      EXPECT_EQ(traces::check(reader, true).culls, 0u);
    }
  }
}

TEST(SecondaryRays, AgreeWithTheReference) {
  const Scene scene = surroundings();
  for (const bool peak : {false, true}) {
    TracerOptions options;
    options.sort_key = peak ? SortKey::peak : SortKey::entry;
    const Traced traced = trace_with(both(), scene, camera(), AccelKind::tlas_tri20, options);
    ReferenceOptions reference;
    reference.objects = both();
    reference.sort_by_peak = peak;
    reference.keep_sequences = true;
    const ReferenceResult exact = render_reference(scene, camera(), reference);
    EXPECT_GE(compare(traced.result.image, exact.image).psnr, 90.0);
    std::size_t different = 0;
    for (std::size_t p = 0; p < exact.sequences.size(); ++p) {
      std::vector<std::uint32_t> ids;
      for (const ReferenceHit& hit : exact.sequences[p]) ids.push_back(hit.gaussian);
      if (ids != traced.result.sequences[p]) ++different;
    }
    EXPECT_LE(different, 1u);
    // The objects are visible: without them the picture is another.
    EXPECT_LT(compare(test::trace_scene(scene, camera(), AccelKind::tlas_tri20, options).image, exact.image).psnr,
              35.0);
  }
}

TEST(SecondaryRays, AHitBeyondTheLimitIsNotBlendedAndOneBeforeItIs) {
  // One round Gaussian: its icosahedron is entered near z = -1; a mirror before or behind that, out of sight beyond it.
  Scene scene;
  scene.name = "one";
  scene.mean = {glm::vec3(0.0f)};
  scene.scale = {glm::vec3(0.4f)};
  scene.rotation = {glm::quat(1, 0, 0, 0)};
  scene.opacity = {0.8f};
  scene.sh = {1.0f, 1.0f, 1.0f};
  Camera one = test::front_camera(1, 1, 4.0);
  one.position = {0, 0, -4};
  for (const double z : {-1.5, -0.9}) {
    OpticalObjects objects;
    objects.mirror = make_mirror({0, 0, z}, {0, 0, -1}, 1.0, 1.0);
    const Traced traced = trace_with(objects, scene, one, AccelKind::tri20, {});
    EXPECT_EQ(traced.result.sequences[0].size(), z < -1.2 ? 0u : 1u) << z;
    EXPECT_EQ(traced.result.secondary.rays, 1u);
    EXPECT_EQ(traced.result.secondary.blended, 0u);
  }
}

TEST(SecondaryRays, AMirrorShowsTheSceneFromTheMirroredCamera) {
  // All Gaussians lie behind the camera, which looks into a large mirror at z = 1: the picture must be that of a camera
  // at the mirrored place that looks the other way, seen from left to right.
  Scene scene = test::random_scene(5);
  scene.sh_degree = 0;
  std::vector<float> flat;
  for (std::size_t g = 0; g < scene.size(); ++g) {
    for (int c = 0; c < 3; ++c) flat.push_back(scene.sh[g * 27 + static_cast<std::size_t>(c)]);
    scene.mean[g].z -= 6.0f;
  }
  scene.sh = flat;
  Camera direct = test::front_camera(33, 25, 0.0);
  direct.position = {0, 0, 0};
  OpticalObjects objects;
  objects.mirror = make_mirror({0, 0, 1}, {0, 0, -1}, 50.0, 50.0);
  const Traced mirrored = trace_with(objects, scene, direct, AccelKind::tri20, {});
  Camera behind = direct;
  behind.position = {0, 0, 2};
  behind.rotation = glm::dmat3(-1, 0, 0, 0, 1, 0, 0, 0, -1);
  const RenderResult seen = test::trace_scene(scene, behind, AccelKind::tri20, {});
  Image flipped(33, 25);
  for (unsigned y = 0; y < 25; ++y) {
    for (unsigned x = 0; x < 33; ++x) flipped.at(x, y) = seen.image.at(32 - x, y);
  }
  EXPECT_GT(seen.counters.blended, 500u);
  EXPECT_GE(compare(mirrored.result.image, flipped).psnr, 80.0);
}

TEST(SecondaryRays, GroupsAreCompactOrderedAndOfOneKind) {
  const Scene scene = surroundings();
  const Traced traced = trace_with(both(), scene, camera(64, 48), AccelKind::tri20, {});
  const auto& groups = traced.plan.groups;
  std::uint32_t next = 0;
  std::size_t partial = 0;
  std::set<traces::RayKind> kinds;
  for (const SecondaryGroup& group : groups) {
    EXPECT_EQ(group.first, next);
    EXPECT_GE(group.count, 1u);
    EXPECT_LE(group.count, kGroupRays);
    next += group.count;
    if (group.count < kGroupRays) ++partial;
    kinds.insert(group.kind);
  }
  EXPECT_EQ(next, traced.plan.rays.size());
  EXPECT_EQ(kinds.size(), 2u);
  EXPECT_LE(partial, 2u * both().max_bounces);  // the last of each run
  EXPECT_EQ(traced.result.secondary.rays, traced.plan.rays.size());
  EXPECT_EQ(traced.result.counters.rays, 64u * 48u + traced.plan.rays.size());
  for (const SecondaryRay& ray : traced.plan.rays) EXPECT_GE(ray.transmittance, 0.001f);
}

TEST(SecondaryRays, ARayThatEndedBeforeTheObjectSendsNone) {
  test::RandomSceneOptions opaque{.count = 150, .log_scale_mean = -1.8, .opacity_low = 0.9, .opacity_high = 1.0};
  const Scene scene = test::random_scene(3, opaque);
  OpticalObjects objects;
  objects.glass = make_glass({0, 0, 0.9}, 1.2, 1.5);  // around and behind half of the scene
  const Camera view = test::front_camera(32, 32);
  const Traced traced = trace_with(objects, scene, view, AccelKind::tri20, {});
  std::uint64_t meet = 0;
  for (unsigned y = 0; y < 32; ++y) {
    for (unsigned x = 0; x < 32; ++x) {
      if (LightPath(objects, view.position, view.direction(x, y)).piece().meets_surface()) ++meet;
    }
  }
  std::uint64_t entered = 0;
  std::set<std::uint32_t> pixels;
  for (const SecondaryRay& ray : traced.plan.rays) entered += pixels.insert(ray.pixel).second ? 1 : 0;
  EXPECT_LT(entered, meet);
  EXPECT_GT(entered, 0u);
}

TEST(SecondaryRays, TraceIsConsistentAndDoesNotDependOnThreads) {
  const Scene scene = surroundings();
  for (const bool checkpoint : {false, true}) {
    TracerOptions options;
    options.checkpoint = checkpoint;
    options.checkpoint_capacity = checkpoint ? 40 : 1024;  // some rays overflow
    const test::TemporaryFolder folder;
    std::vector<std::string> bytes;
    for (const unsigned threads : {1u, 3u}) {
      const std::string path = folder.path(std::to_string(threads) + ".grtx");
      const Traced traced = trace_with(both(), scene, camera(), AccelKind::tlas_tri20, options, threads, path);
      const traces::Reader reader(path);
      EXPECT_EQ(traces::check(reader, true).blended, traced.result.counters.blended);
      EXPECT_EQ(reader.totals().visits(), traced.result.counters.visits());
      ASSERT_EQ(reader.group_count(), 4u * 6u + traced.plan.groups.size());
      traces::RayGroup group;
      std::uint64_t secondary_rays = 0;
      for (std::uint64_t i = 0; i < reader.group_count(); ++i) {
        reader.read(i, group);
        EXPECT_EQ(group.kind == traces::RayKind::primary, i < 24);
        if (i >= 24) secondary_rays += group.rays.size();
      }
      EXPECT_EQ(secondary_rays, traced.result.secondary.rays);
      bytes.push_back(folder.read(std::to_string(threads) + ".grtx"));
    }
    EXPECT_EQ(bytes[0], bytes[1]);
  }
}

TEST(SecondaryRays, RandomPlacesAreInViewApartAndRepeatable) {
  const Scene scene = test::random_scene(9);
  const Camera view = test::front_camera(64, 48);
  std::set<double> places;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const OpticalObjects objects = place_at_random(scene, view, true, true, 1.5, seed);
    ASSERT_NO_THROW(check_apart(objects));
    EXPECT_EQ(objects.glass->centre, place_at_random(scene, view, true, true, 1.5, seed).glass->centre);
    places.insert(objects.glass->centre.x);
    std::size_t glass = 0, mirror = 0;
    for (unsigned y = 0; y < 48; ++y) {
      for (unsigned x = 0; x < 64; ++x) {
        LightPath path(objects, view.position, view.direction(x, y));
        if (!path.piece().meets_surface()) continue;
        path.advance();
        ++(path.piece().kind == traces::RayKind::glass ? glass : mirror);
      }
    }
    EXPECT_GT(glass, 64u * 48u / 50u) << seed;
    EXPECT_GT(mirror, 64u * 48u / 50u) << seed;
  }
  EXPECT_EQ(places.size(), 50u);
}

}  // namespace
}  // namespace grtx::frontend
