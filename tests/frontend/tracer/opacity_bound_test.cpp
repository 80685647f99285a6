// SPDX-License-Identifier: Apache-2.0
// The end of a ray where its hits let no light through (docs/model/tracer.md, "Bound by opacity"): it changes no image
// and no sequence, saves visits, and a trace that claims it wrongly is found.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "frontend/synth/stress_scenes.h"
#include "frontend/tracer/random_scene.h"
#include "frontend/tracer/render_helpers.h"
#include "grtx/base/error.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/reference/reference.h"
#include "grtx/frontend/tracer/ray_tracer.h"
#include "grtx/frontend/tracer/secondary_plan.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/traces/check.h"
#include "grtx/traces/reader.h"
#include "grtx/traces/writer.h"
#include "traces/temporary_file.h"

namespace grtx::frontend {
namespace {

/// As explore/sweep/designs.cpp has them.
struct DesignOptions {
  const char* name;
  AccelKind accel;
  traces::NodeLayout layout;
  TracerOptions options;
};

std::vector<DesignOptions> designs() {
  TracerOptions shaders, checkpoints, gautracer, walk;
  shaders.child_order = checkpoints.child_order = ChildOrder::slot;
  checkpoints.checkpoint = true;
  gautracer.k = 16;
  gautracer.sort_key = SortKey::peak;
  gautracer.tmax_update = TmaxUpdate::kth;
  gautracer.child_order = ChildOrder::slot;
  walk.k = 64;
  walk.tmax_update = TmaxUpdate::kth;
  walk.ahead = 16;
  using traces::NodeLayout;
  return {{"baseline", AccelKind::tri20, NodeLayout::vulkan_sim, shaders},
          {"sw", AccelKind::tlas_tri20, NodeLayout::vulkan_sim, shaders},
          {"hw", AccelKind::tri20, NodeLayout::vulkan_sim, checkpoints},
          {"grtx", AccelKind::tlas_tri20, NodeLayout::vulkan_sim, checkpoints},
          {"gautracer", AccelKind::ellipsoid, NodeLayout::vulkan_sim, gautracer},
          {"walk", AccelKind::ellipsoid, NodeLayout::quantised, walk}};
}

/// Structures of a design for one scene.
struct Traced {
  Traced(const Scene& of, const DesignOptions& design)
      : scene(of),
        gaussians(of, true, is_quantised(design.layout)),
        accel(gaussians, {design.accel, 6, false, 8, design.layout}) {}

  RenderResult render(const Camera& camera, TracerOptions options, OpacityBound bound) const {
    options.opacity_bound = bound;
    return test::trace_scene(scene, camera, accel, gaussians, options);
  }

  const Scene& scene;
  const PreparedGaussians gaussians;
  const AccelerationStructure accel;
};

void expect_same_image(const RenderResult& off, const RenderResult& on, const std::string& what) {
  EXPECT_TRUE(compare(off.image, on.image).identical()) << what;
  EXPECT_TRUE(off.sequences == on.sequences) << what;
  EXPECT_EQ(off.counters.processed, on.counters.processed) << what;
  EXPECT_EQ(off.counters.terminated, on.counters.terminated) << what;
  EXPECT_LE(on.counters.rounds, off.counters.rounds) << what;
  EXPECT_LE(on.counters.visits(), off.counters.visits()) << what;
  EXPECT_LE(on.counters.checkpoints_written, off.counters.checkpoints_written) << what;
  EXPECT_LE(on.counters.any_hit_calls(), off.counters.any_hit_calls()) << what;
}

TEST(OpacityBound, ChangesNoImageInAnyDesignAndSavesVisits) {
  for (const char* preset : {"room", "object", "hall", "stress-ties", "stress-copies"}) {
    const test::GeneratedScene generated = test::generated_scene(preset, preset[0] == 's' ? 200 : 1500, 0);
    const Camera camera = test::small_view(generated, 0, 12);
    for (DesignOptions design : designs()) {
      const Traced traced(generated.scene, design);
      std::uint64_t visits_off = 0, visits_on = 0;
      for (const unsigned k : {1u, 4u, design.options.k, 256u}) {
        design.options.k = k;
        const std::string what = std::string(preset) + " " + design.name + " k " + std::to_string(k);
        const RenderResult off = traced.render(camera, design.options, OpacityBound::off);
        const RenderResult on = traced.render(camera, design.options, OpacityBound::on);
        expect_same_image(off, on, what);
        EXPECT_FALSE(off.counters.opacity.has_value());
        ASSERT_TRUE(on.counters.opacity.has_value());
        visits_off += off.counters.visits();
        visits_on += on.counters.visits();
      }
      if (preset[0] != 's') {
        EXPECT_LT(visits_on, visits_off) << preset << " " << design.name;
      }
    }
  }
}

TEST(OpacityBound, TheImageIsThatOfTheReferenceInEveryDesign) {
  for (const char* preset : {"room", "object", "hall"}) {
    const test::GeneratedScene generated = test::generated_scene(preset, 800);
    const Camera camera = test::small_view(generated, 0, 16);
    for (const DesignOptions& design : designs()) {
      if (design.layout == traces::NodeLayout::quantised) continue;  // its leaves hold rounded Gaussians
      const Traced traced(generated.scene, design);
      ReferenceOptions reference;
      reference.proxy = design.accel == AccelKind::ellipsoid ? ReferenceProxy::sphere : ReferenceProxy::icosahedron20;
      reference.sort_by_peak = design.options.sort_key == SortKey::peak;
      const ReferenceResult exact = render_reference(generated.scene, camera, reference);
      const RenderResult on = traced.render(camera, design.options, OpacityBound::on);
      EXPECT_GE(compare(on.image, exact.image).psnr, 60.0) << preset << " " << design.name;
    }
  }
}

TEST(OpacityBound, IsExactWithEveryOptionThatMovesTMaxOrKeepsNodes) {
  const Scene scene = test::random_scene(7, {.count = 400, .log_scale_mean = -1.8, .opacity_high = 0.99});
  const Camera camera = test::front_camera(10, 10, 1.2);  // inside the scene
  unsigned variant = 0;
  std::uint64_t overflows = 0, hidden = 0;
  for (const AccelKind kind : {AccelKind::tri20, AccelKind::tlas_sphere, AccelKind::box, AccelKind::tlas_tri80}) {
    const Traced traced(scene, {"", kind, traces::NodeLayout::vulkan_sim, {}});
    for (const unsigned k : {1u, 3u, 12u, 40u}) {
      for (unsigned i = 0; i < 8; ++i, ++variant) {
        TracerOptions options;
        options.k = k;
        options.checkpoint = i % 2 != 0;
        options.checkpoint_order = static_cast<CheckpointOrder>(variant % 3);
        options.checkpoint_capacity = i == 3 ? 9 : 1024;
        if (i == 5) options.checkpoint_bins = 4, options.checkpoint_order = CheckpointOrder::fifo;
        if (i == 7) options.below_instance = BelowInstance::finish;
        options.tmax_update = variant % 2 != 0 ? TmaxUpdate::kth : TmaxUpdate::reported;
        options.replay_tmax = variant % 3 != 0 ? ReplayTmax::kth : ReplayTmax::infinity;
        options.pop_test = variant % 5 == 0 ? PopTest::off : PopTest::on;
        options.child_order = static_cast<ChildOrder>(variant / 2 % 3);
        options.sort_key = variant % 7 < 3 ? SortKey::peak : SortKey::entry;
        options.ert = variant % 4 == 0 ? 0.2f : 0.001f;
        options.response_precision = variant % 6 == 0 ? ResponsePrecision::fp16 : ResponsePrecision::fp32;
        if (kind == AccelKind::box && !options.checkpoint) options.ahead = 1 + variant % 9;
        const RenderResult off = traced.render(camera, options, OpacityBound::off);
        const RenderResult on = traced.render(camera, options, OpacityBound::on);
        const std::string what = accel_name(kind) + " k " + std::to_string(k) + " variant " + std::to_string(variant);
        EXPECT_TRUE(compare(off.image, on.image).identical()) << what;
        EXPECT_TRUE(off.sequences == on.sequences) << what;
        if (options.checkpoint_bins == 0) {
          EXPECT_LE(on.counters.visits(), off.counters.visits()) << what;
        }
        overflows += on.counters.checkpoint_overflows;
        hidden += on.counters.opacity->hidden;
      }
    }
  }
  EXPECT_GT(overflows, 20u);
  EXPECT_GT(hidden, 1000u);
}

// A ray that begins dimmed, and ends at a surface.
TEST(OpacityBound, IsExactForPiecesOfAPathThatGlassAndMirrorsMake) {
  const Scene scene = test::random_scene(9, {.count = 300, .log_scale_mean = -1.8, .opacity_high = 0.9});
  const PreparedGaussians gaussians(scene, true);
  const AccelerationStructure accel(gaussians, {AccelKind::tlas_sphere, 6, false});
  const Camera camera = test::front_camera(12, 12, 3.0);
  for (const bool checkpoint : {false, true}) {
    TracerOptions options;
    options.k = 4;
    options.checkpoint = checkpoint;
    RayTracer off(scene, gaussians, accel, options);
    options.opacity_bound = OpacityBound::on;
    RayTracer on(scene, gaussians, accel, options);
    NullRecorder recorder;
    for (std::uint32_t pixel = 0; pixel < 144; ++pixel) {
      const TraceRay ray(glm::vec3(camera.position), glm::vec3(camera.direction(pixel % 12, pixel / 12)));
      const float before = pixel % 3 == 0 ? 1.0f : 0.01f;
      const float limit = pixel % 4 == 0 ? 3.0f : std::numeric_limits<float>::infinity();
      const RayResult expected = off.trace(ray, recorder, before, limit),
                      found = on.trace(ray, recorder, before, limit);
      EXPECT_EQ(expected.colour, found.colour) << pixel;
      EXPECT_EQ(expected.transmittance, found.transmittance) << pixel;
    }
    EXPECT_LT(on.counters().visits(), off.counters().visits());
    EXPECT_GT(on.counters().opacity->rays, 30u);
  }
}

class BoundedTrace : public testing::Test {
 protected:
  /// Calls f with each group of a bounded trace, and its header.
  static void for_each_group(const std::function<void(const traces::Header&, const traces::RayGroup&)>& f) {
    const test::GeneratedScene generated = test::generated_scene("room", 2000, 0);
    const Camera camera = test::small_view(generated, 0, 16);
    for (const DesignOptions& design : designs()) {
      const Traced traced(generated.scene, design);
      TracerOptions options = design.options;
      options.opacity_bound = OpacityBound::on;
      RenderOptions render;
      render.threads = 1;
      render.quiet = true;
      const traces::testing::TemporaryFile file("bounded");
      traces::Writer writer(file.path(), trace_header(generated.scene, camera, traced.accel, options, render));
      (void)frontend::render({generated.scene, traced.gaussians, traced.accel}, camera, options, render, &writer);
      writer.finish();
      const traces::Reader reader(file.path());
      EXPECT_EQ(traces::check(reader, true), reader.totals()) << design.name;
      traces::RayGroup group;
      for (std::uint64_t g = 0; g < reader.group_count(); ++g) {
        reader.read(g, group);
        f(reader.header(), group);
      }
    }
  }
  /// The rule that the check names; "" if it passes.
  static std::string fault_of(const traces::Header& header, const traces::RayGroup& group) {
    try {
      traces::check_group("a trace", header, group);
      return "";
    } catch (const Error& error) {
      return error.rule();
    }
  }
};

TEST_F(BoundedTrace, ThatIsDoctoredIsFound) {
  std::uint64_t hidden = 0, dropped = 0, terminated = 0, denied = 0;
  for_each_group([&](const traces::Header& header, const traces::RayGroup& traced) {
    EXPECT_EQ(header.opacity_bound, OpacityBound::on);
    traces::RayGroup group = traced;
    // A header that denies the bound.
    traces::Header off = header;
    off.opacity_bound = OpacityBound::off;
    for (traces::Ray& ray : group.rays) {
      bool hides = false;
      for (traces::Event& event : ray.events) {
        if (event.hidden() == 0) continue;
        hides = true;
        ++hidden;
        const std::uint8_t before = event.checkpoints;
        for (const unsigned other : {before - 1u, before + 1u, 255u}) {
          event.checkpoints = static_cast<std::uint8_t>(other);
          EXPECT_NE(fault_of(header, group), "") << "an entry more or less leaves";
        }
        event.checkpoints = before;
        if (hidden % 50 != 1) break;
      }
      if (!hides) continue;
      EXPECT_NE(fault_of(off, group), "");
      ++denied;
      traces::Round& last = ray.rounds.back();
      if (!last.terminated) continue;
      last.terminated = false;  // what was hidden would then be seen
      EXPECT_NE(fault_of(header, group), "");
      if (last.processed_count == last.k_count && last.k_count < header.k) {
        EXPECT_EQ(fault_of(header, group), "a ray that leaves out what its hits hide must be terminated by them");
        ++terminated;
      }
      last.terminated = true;
    }
    if (!header.checkpoint) return;
    for (traces::Ray& ray : group.rays) {  // a node that opacity does not hide is dropped
      if (ray.rounds.back().terminated) continue;
      for (traces::Event& event : ray.events) {
        if (event.kind() != traces::EventKind::cull || event.checkpoints == 0) continue;
        event.checkpoints = 0;
        EXPECT_NE(fault_of(header, group), "");
        event.checkpoints = 1;
        ++dropped;
        break;
      }
    }
  });
  EXPECT_GT(hidden, 50u);
  EXPECT_GT(denied, 50u);
  EXPECT_GT(terminated, 20u);
  EXPECT_GT(dropped, 20u);
}

}  // namespace
}  // namespace grtx::frontend
