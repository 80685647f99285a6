// SPDX-License-Identifier: Apache-2.0
// A beam against its rays: no box that one of them meets is missed, and what a trace says of it.
#include "grtx/frontend/tracer/ray_beam.h"

#include <gtest/gtest.h>

#include <bit>
#include <random>
#include <vector>

#include "frontend/tracer/random_scene.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/traces/check.h"
#include "grtx/traces/reader.h"
#include "traces/temporary_file.h"

namespace grtx::frontend {
namespace {

using traces::EventKind;

bool any_meets(const std::vector<SlabRay>& rays, const Box& box) {
  for (const SlabRay& ray : rays) {
    const Interval interval = conservative_interval(ray, box);
    if (!interval.empty() && interval.exit >= 0.0f) return true;
  }
  return false;
}

TEST(RayBeam, MeetsEveryBoxThatOneOfItsRaysMeets) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  const auto point = [&](float scale) { return scale * glm::vec3(unit(random), unit(random), unit(random)); };
  unsigned met = 0, in_vain = 0, missed = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    const glm::vec3 origin = point(1.0f), direction = point(1.0f);
    const float spread = trial % 3 == 0 ? 1.5f : 0.05f;  // wide beams have rays of both signs
    const float apart = trial % 2 == 0 ? 0.0f : 0.2f;    // a camera's rays have one origin
    const float axis = trial % 5 == 0 ? 0.0f : 1.0f;     // rays along a plane: reciprocals are FLT_MAX
    std::vector<SlabRay> rays;
    RayBeam beam;
    for (unsigned lane = 0; lane < 1 + random() % 32; ++lane) {
      glm::vec3 d = direction + point(spread);
      d.y *= axis;
      rays.emplace_back(origin + point(apart), glm::normalize(d));
      beam.add(rays.back());
    }
    Box box;
    const glm::vec3 centre = trial % 4 < 2 ? origin + 3.0f * direction + point(0.5f) : point(3.0f);  // half lie ahead
    box.extend(centre);
    box.extend(centre + point(trial % 7 == 0 ? 0.0f : 1.0f));
    if (any_meets(rays, box)) {
      EXPECT_TRUE(beam.meets(box)) << "trial " << trial;
      ++met;
    } else {
      ++(beam.meets(box) ? in_vain : missed);
    }
  }
  EXPECT_GT(met, 1000u);
  EXPECT_GT(missed, 5000u) << "it says nothing; in vain " << in_vain;
}

TEST(RayBeam, OfNoRaysMeetsNothing) {
  RayBeam beam;
  Box box;
  box.extend(glm::vec3(-1.0f));
  box.extend(glm::vec3(1.0f));
  EXPECT_FALSE(beam.meets(box));
  beam.add(SlabRay(glm::vec3(0.0f), glm::vec3(0.0f, 0.0f, 1.0f)));
  EXPECT_TRUE(beam.meets(box)) << "the origin is inside";
  beam.clear();
  EXPECT_FALSE(beam.meets(box));
}

// Images, events and all else of a trace are those of one without beams.
TEST(RayBeam, ATraceWithBeamsHoldsTheSameEvents) {
  const Scene scene = grtx::test::random_scene(81, {.count = 600, .log_scale_mean = -2.5});
  const Camera camera = grtx::test::front_camera(24, 12, 2.0);
  const RenderOptions render{.threads = 1};
  for (const ChildOrder order : {ChildOrder::slot, ChildOrder::near_first}) {
    TracerOptions options;
    options.child_order = order;
    options.k = 4;
    const PreparedGaussians gaussians(scene, options.kernel);
    const AccelerationStructure accel(gaussians, {AccelKind::ellipsoid, 6, false});
    const auto trace = [&](WarpBeam beams, const std::string& path) {
      options.warp_beam = beams;
      traces::Writer writer(path, trace_header(scene, camera, accel, options, render));
      frontend::render(scene, gaussians, accel, camera, options, render, &writer);
      writer.finish();
    };
    const traces::testing::TemporaryFile with("with"), without("without");
    trace(WarpBeam::on, with.path());
    trace(WarpBeam::off, without.path());
    const traces::Reader beams(with.path()), plain(without.path());
    EXPECT_NO_THROW(traces::check(beams, true));
    EXPECT_EQ(beams.totals(), plain.totals());
    std::uint64_t met = 0, children = 0, hit = 0;
    for (std::uint64_t i = 0; i < plain.group_count(); ++i) {
      traces::RayGroup a, b;
      beams.read(i, a);
      plain.read(i, b);
      std::vector<unsigned> pushed(a.nodes.size());
      for (const traces::Ray& ray : a.rays) {
        for (const traces::Event& event : ray.events) {
          if (event.kind() == EventKind::visit_internal) pushed[event.node] |= event.pushed();
        }
      }
      for (std::size_t n = 0; n < a.nodes.size(); ++n) {
        EXPECT_EQ(pushed[n] & ~unsigned{a.nodes[n].beam}, 0u);
        met += static_cast<unsigned>(std::popcount(a.nodes[n].beam));
        hit += static_cast<unsigned>(std::popcount(pushed[n]));
        children += a.nodes[n].child_count;
        a.nodes[n].beam = 0;
      }
      EXPECT_EQ(a, b) << "group " << i;
    }
    EXPECT_GE(met, hit);
    EXPECT_LT(met, children) << "the beam leaves nothing out";
  }
}

}  // namespace
}  // namespace grtx::frontend
