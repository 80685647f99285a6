// SPDX-License-Identifier: Apache-2.0
// Orders of children, test of popped nodes and orders of checkpoints, all together: the events of each ray against a
// second implementation, and the image against that of the defaults.
#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <string>
#include <vector>

#include "frontend/tracer/plain_tracer.h"
#include "frontend/tracer/random_scene.h"
#include "frontend/tracer/render_helpers.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/tracer/encoding_recorder.h"
#include "grtx/frontend/tracer/ray_tracer.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/traces/check.h"
#include "grtx/traces/codec/file_layout.h"
#include "grtx/traces/codec/group_codec.h"

namespace grtx::frontend {
namespace {

constexpr AccelKind kOrderedKinds[] = {AccelKind::tri20,       AccelKind::tlas_tri20, AccelKind::ellipsoid,
                                       AccelKind::tlas_sphere, AccelKind::tri80,      AccelKind::tlas_tri80};

struct Sums {
  std::uint64_t visits = 0, culls = 0, checkpoints = 0, overflows = 0, taken = 0;
};

class Comparison {
 public:
  Comparison(const Scene& scene, const PreparedGaussians& gaussians, const AccelerationStructure& accel,
             const Camera& camera, const TracerOptions& options)
      : header_(trace_header(scene, camera, accel, options, {})),
        accel_(accel),
        camera_(camera),
        tracer_(scene, gaussians, accel, options),
        plain_(gaussians, accel, options),
        groups_(map_pixels(camera.width, camera.height, false)) {}

  /// Entries that left k-buffers.
  unsigned hidden() const { return hidden_; }
  /// Every group as the trace tells it, against the plain tracer.
  void run(Sums& sums) {
    for (std::uint32_t i = 0; i < groups_.size(); ++i) {
      const traces::RayGroup group = traced(i);
      sums.overflows += traces::check_group("a traced group", header_, group).overflows;
      for (const traces::Ray& ray : group.rays) {
        expect_plain(group, ray, sums);
        if (testing::Test::HasFailure()) return;
      }
    }
  }

 private:
  TraceRay ray_of(std::uint32_t pixel) const {
    return {glm::vec3(camera_.position), glm::vec3(camera_.direction(pixel % camera_.width, pixel / camera_.width))};
  }
  static float limit_of(std::uint32_t pixel) { return pixel % 3 == 0 ? 1.3f : std::numeric_limits<float>::infinity(); }

  template <typename Recorder>
  traces::RayGroup recorded(std::uint32_t index, Recorder recorder) {
    recorder.begin_group(index, traces::RayKind::primary);
    for (const std::uint32_t pixel : groups_[index]) {
      recorder.begin_ray(pixel);
      tracer_.trace(ray_of(pixel), recorder, 1.0f, limit_of(pixel));
    }
    const traces::EncodedGroup encoded = recorder.end_group();
    traces::RayGroup group;
    traces::decode_group(header_, encoded.chunk.data() + traces::kChunkPreambleBytes,
                         encoded.chunk.size() - traces::kChunkPreambleBytes, index, group);
    return group;
  }
  traces::RayGroup traced(std::uint32_t index) {
    if (EncodingRecorder::can_record(header_)) return recorded(index, EncodingRecorder(accel_.image(), header_));
    return recorded(index, GroupRecorder(accel_.image(), &header_));
  }

  void expect_plain(const traces::RayGroup& group, const traces::Ray& ray, Sums& sums) {
    plain_.begin_ray(ray_of(ray.pixel), limit_of(ray.pixel));
    std::size_t event = 0, processed = 0;
    for (std::size_t r = 0; r < ray.rounds.size(); ++r) {
      const traces::Round& round = ray.rounds[r];
      const test::PlainTracer::Round expected = plain_.round();
      const std::string place = "pixel " + std::to_string(ray.pixel) + " round " + std::to_string(r);
      ASSERT_EQ(round.replay, expected.replay) << place;
      ASSERT_EQ(round.overflow, expected.overflow) << place;
      ASSERT_EQ(round.preloaded, expected.preloaded) << place;
      ASSERT_EQ(round.k_count, expected.k_buffer.size()) << place;
      for (std::size_t i = 0; i < round.processed_count; ++i, ++processed) {
        ASSERT_EQ(ray.processed[processed].gaussian, expected.k_buffer[i]) << place << " entry " << i;
      }
      ASSERT_EQ(round.event_count, expected.events.size()) << place;
      for (std::size_t e = 0; e < expected.events.size(); ++e, ++event) {
        const traces::Event& got = ray.events[event];
        const std::uint32_t units =
            got.kind() == traces::EventKind::visit_internal ? group.nodes[got.node].address : got.node;
        const test::PlainTracer::Event as_plain{got.kind(), std::uint64_t{units} * traces::kNodeUnit, got.detail,
                                                got.checkpoints};
        ASSERT_TRUE(as_plain == expected.events[e]) << place << " event " << e;
        sums.visits += got.kind() <= traces::EventKind::visit_leaf ? 1 : 0;
        sums.culls += got.kind() == traces::EventKind::cull ? 1 : 0;
        sums.taken += got.kind() == traces::EventKind::replay_take ? 1 : 0;
        sums.checkpoints += static_cast<unsigned>(std::popcount(got.written()));
        hidden_ += got.hidden();
      }
    }
    EXPECT_EQ(processed, ray.processed.size());
  }

  const traces::Header header_;
  const AccelerationStructure& accel_;
  const Camera camera_;
  RayTracer tracer_;
  test::PlainTracer plain_;
  const std::vector<std::vector<std::uint32_t>> groups_;
  unsigned hidden_ = 0;
};

std::string text(const TracerOptions& o, AccelKind kind) {
  return accel_name(kind) + " k " + std::to_string(o.k) + (o.checkpoint ? " checkpoint " : " restart ") +
         std::string(name_of(o.checkpoint_order)) + " " + std::string(name_of(o.child_order)) + " pop test " +
         std::string(name_of(o.pop_test));
}

Scene crowded() {
  Scene scene = test::random_scene(92, {.count = 160, .log_scale_mean = -1.9, .opacity_high = 0.99});
  for (std::size_t i = 1; i < scene.size(); i += 9) {  // pairs that tie
    scene.mean[i] = scene.mean[i - 1];
    scene.scale[i] = scene.scale[i - 1];
    scene.rotation[i] = scene.rotation[i - 1];
  }
  return scene;
}

// Three orders x pop test x six structures, each without checkpointing and with it in one of three orders.
TEST(ChildOrders, GiveTheEventsOfASecondImplementation) {
  const Scene scene = crowded();
  const PreparedGaussians gaussians(scene, true);
  const Camera camera = test::front_camera(12, 8, 1.2);  // inside the scene
  unsigned variant = 0;
  Sums with_test, without_test;
  for (const AccelKind kind : kOrderedKinds) {
    const AccelerationStructure accel(gaussians, {kind, kind == AccelKind::tri20 ? 8u : 6u, false});
    for (const auto& order : enum_names(ChildOrder{})) {
      for (const bool checkpoint : {false, true}) {
        ++variant;
        for (const PopTest pop_test : {PopTest::on, PopTest::off}) {
          TracerOptions options;
          options.k = 1u << variant % 5;
          options.child_order = order.value;
          options.pop_test = pop_test;
          options.checkpoint = checkpoint;
          options.checkpoint_order = enum_names(CheckpointOrder{})[variant / 2 % 3].value;
          options.checkpoint_capacity = variant % 8 == 0 ? 10 : 1024;
          SCOPED_TRACE(text(options, kind));
          Comparison(scene, gaussians, accel, camera, options).run(pop_test == PopTest::on ? with_test : without_test);
          if (HasFailure()) return;
        }
      }
    }
  }
  EXPECT_GT(with_test.culls, 1000u);
  EXPECT_EQ(without_test.culls, 0u);
  EXPECT_GT(without_test.visits, with_test.visits) << "what was pushed is fetched";
  for (const Sums& sums : {with_test, without_test}) {
    EXPECT_GT(sums.checkpoints, 1000u);
    EXPECT_GT(sums.taken, 1000u);
    EXPECT_GT(sums.overflows, 10u);
  }
}

// Nodes under way at once: a second implementation whose stack is a map from paths.
TEST(ChildOrders, NodesUnderWayAtOnceGiveTheEventsOfASecondImplementation) {
  const Scene scene = crowded();
  const PreparedGaussians gaussians(scene, true);
  const Camera camera = test::front_camera(12, 8, 1.2);
  unsigned variant = 0;
  Sums sums;
  for (const AccelKind kind : {AccelKind::tri20, AccelKind::ellipsoid}) {
    const AccelerationStructure accel(gaussians, {kind, kind == AccelKind::tri20 ? 8u : 6u, false});
    for (const auto& order : enum_names(ChildOrder{})) {
      for (const unsigned ahead : {2u, 5u, 32u}) {
        ++variant;
        TracerOptions options;
        options.ahead = ahead;
        options.k = 1u << variant % 5;
        options.child_order = order.value;
        options.pop_test = variant % 2 == 0 ? PopTest::on : PopTest::off;
        options.tmax_update = variant % 3 == 0 ? TmaxUpdate::kth : TmaxUpdate::reported;
        SCOPED_TRACE(text(options, kind) + " ahead " + std::to_string(ahead));
        Comparison(scene, gaussians, accel, camera, options).run(sums);
        if (HasFailure()) return;
      }
    }
  }
  EXPECT_GT(sums.culls, 100u);
}

// The end of a ray where its hits let no light through: a second implementation that adds up logarithms of the hits in
// order, from the first, after each one.
TEST(ChildOrders, TheBoundByOpacityGivesTheEventsOfASecondImplementation) {
  const Scene scene = crowded();
  const PreparedGaussians gaussians(scene, true);
  const Camera camera = test::front_camera(12, 8, 1.2);
  unsigned variant = 0, hidden = 0;
  Sums sums;
  for (const AccelKind kind : kOrderedKinds) {
    const AccelerationStructure accel(gaussians, {kind, kind == AccelKind::tri20 ? 8u : 6u, false});
    for (const auto& order : enum_names(ChildOrder{})) {
      for (const bool checkpoint : {false, true}) {
        ++variant;
        TracerOptions options;
        options.opacity_bound = OpacityBound::on;
        options.ert = variant % 4 == 0 ? 0.3f : 0.001f;
        options.k = 1u << variant % 6;
        options.child_order = order.value;
        options.checkpoint = checkpoint;
        options.checkpoint_order = enum_names(CheckpointOrder{})[variant / 2 % 3].value;
        options.checkpoint_capacity = variant % 4 == 0 ? 4 : 1024;
        options.pop_test = variant % 5 == 0 ? PopTest::off : PopTest::on;
        options.tmax_update = variant % 3 == 0 ? TmaxUpdate::kth : TmaxUpdate::reported;
        const bool one_level = kind == AccelKind::tri20 || kind == AccelKind::ellipsoid;
        if (!checkpoint && one_level) options.ahead = 1 + 5 * (variant % 3);
        SCOPED_TRACE(text(options, kind) + " ahead " + std::to_string(options.ahead));
        Comparison comparison(scene, gaussians, accel, camera, options);
        comparison.run(sums);
        hidden += comparison.hidden();
        if (HasFailure()) return;
      }
    }
  }
  EXPECT_GT(hidden, 300u);
  EXPECT_GT(sums.taken, 300u);
  EXPECT_GT(sums.overflows, 5u);
}

// Any-hit shaders that run behind a round's traversal: a second implementation that queues the hits and takes them
// then.
TEST(ChildOrders, DelayedAnyHitShadersGiveTheEventsOfASecondImplementation) {
  const Scene scene = crowded();
  const PreparedGaussians gaussians(scene, true);
  const Camera camera = test::front_camera(12, 8, 1.2);
  unsigned variant = 0;
  Sums sums;
  for (const AccelKind kind : kOrderedKinds) {
    const AccelerationStructure accel(gaussians, {kind, kind == AccelKind::tri20 ? 8u : 6u, false});
    for (const auto& order : enum_names(ChildOrder{})) {
      ++variant;
      TracerOptions options;
      options.any_hit = AnyHit::delayed;
      options.k = 1u << variant % 5;
      options.child_order = order.value;
      options.pop_test = variant % 2 == 0 ? PopTest::on : PopTest::off;
      options.tmax_update = variant % 3 == 0 ? TmaxUpdate::kth : TmaxUpdate::reported;
      SCOPED_TRACE(text(options, kind));
      Comparison(scene, gaussians, accel, camera, options).run(sums);
      if (HasFailure()) return;
    }
  }
  EXPECT_GT(sums.visits, 1000u);
  EXPECT_EQ(sums.culls, 0u) << "t_max stays";
}

// Nothing is lost and nothing processed twice, whatever the order and whether stale nodes are fetched: image and
// sequence of blended Gaussians are those of the defaults.
TEST(ChildOrders, ChangeNoImage) {
  const Scene scene = crowded();
  const PreparedGaussians gaussians(scene, true);
  const Camera camera = test::front_camera(8, 8, 1.2);
  for (std::size_t proxy = 0; proxy < 6; proxy += 2) {
    RenderResult expected;
    for (const AccelKind kind : {kOrderedKinds[proxy], kOrderedKinds[proxy + 1]}) {
      const AccelerationStructure accel(gaussians, {kind, 6, false});
      if (expected.image.pixels.empty()) expected = test::trace_scene(scene, camera, accel, gaussians, {});
      for (const auto& order : enum_names(ChildOrder{})) {
        for (const PopTest pop_test : {PopTest::on, PopTest::off}) {
          for (const unsigned read_order : {0u, 1u, 2u, 3u}) {  // 3: no checkpointing
            TracerOptions options;
            options.k = 4;
            options.child_order = order.value;
            options.pop_test = pop_test;
            options.checkpoint = read_order < 3;
            options.checkpoint_order = enum_names(CheckpointOrder{})[read_order % 3].value;
            const RenderResult result = test::trace_scene(scene, camera, accel, gaussians, options);
            EXPECT_TRUE(compare(expected.image, result.image).identical()) << text(options, kind);
            EXPECT_TRUE(expected.sequences == result.sequences) << text(options, kind);
            EXPECT_EQ(expected.counters.processed, result.counters.processed) << text(options, kind);
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace grtx::frontend
