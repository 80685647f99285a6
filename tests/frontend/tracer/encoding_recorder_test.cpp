// SPDX-License-Identifier: Apache-2.0
// Groups encoded while they are traced against the same groups encoded from their events, byte for byte.
#include "grtx/frontend/tracer/encoding_recorder.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "frontend/tracer/random_scene.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/tracer/ray_recorder.h"
#include "grtx/frontend/tracer/ray_tracer.h"
#include "grtx/frontend/tracer/tracer.h"

namespace grtx::frontend {
namespace {

using traces::EncodedGroup;

template <typename Recorder>
EncodedGroup trace_group(RayTracer& tracer, Recorder& recorder, const Camera& camera,
                         const std::vector<std::uint32_t>& pixels, std::uint32_t index) {
  recorder.begin_group(index, traces::RayKind::primary);
  for (const std::uint32_t pixel : pixels) {
    recorder.begin_ray(pixel);
    if (pixel % 37 == 5) continue;  // as where the projection has no ray
    const glm::dvec3 direction = camera.direction(pixel % camera.width, pixel / camera.width);
    const float limit = pixel % 3 == 0 ? 1.3f : std::numeric_limits<float>::infinity();
    tracer.trace(TraceRay(glm::vec3(camera.position), glm::vec3(direction)), recorder, 1.0f, limit);
  }
  return recorder.end_group();
}

/// What the groups came to.
struct RecordedSums {
  traces::Totals totals;
  std::uint64_t misses = 0;  ///< rays that miss the scene
};

RecordedSums compare(const Scene& scene, const PreparedGaussians& gaussians, const AccelerationStructure& accel,
                     const Camera& camera, const TracerOptions& options, const RenderOptions& render) {
  const traces::Header header = trace_header(scene, camera, accel, options, render);
  RayTracer encoding(scene, gaussians, accel, options), recording(scene, gaussians, accel, options);
  EncodingRecorder encoder(accel.image(), header);
  GroupRecorder recorder(accel.image(), &header);
  RecordedSums sums;
  const auto groups = map_pixels(camera.width, camera.height, render.linear_mapping, render.warp_size);
  for (std::uint32_t i = 0; i < groups.size(); ++i) {
    const EncodedGroup got = trace_group(encoding, encoder, camera, groups[i], i);
    const EncodedGroup expected = trace_group(recording, recorder, camera, groups[i], i);
    EXPECT_EQ(got.index, expected.index);
    EXPECT_EQ(got.totals, expected.totals) << "group " << i;
    EXPECT_TRUE(got.chunk == expected.chunk) << "group " << i;
    // A group is the same whichever its thread traced before it.
    RayTracer first(scene, gaussians, accel, options);
    EncodingRecorder alone(accel.image(), header);
    EXPECT_TRUE(trace_group(first, alone, camera, groups[i], i).chunk == got.chunk) << "group " << i << " alone";
    add_totals(sums.totals, got.totals);
  }
  sums.misses = encoding.counters().skipped_scene_misses;
  return sums;
}

TEST(EncodingRecorder, GivesTheBytesOfTheEventsEncodedAfterwards) {
  Scene scene = test::random_scene(91, {.count = 250, .log_scale_mean = -2.0, .opacity_high = 0.99});
  for (std::size_t i = 1; i < scene.size(); i += 9) {  // pairs that tie
    scene.mean[i] = scene.mean[i - 1];
    scene.scale[i] = scene.scale[i - 1];
    scene.rotation[i] = scene.rotation[i - 1];
  }
  const PreparedGaussians gaussians(scene, true);
  traces::Totals all;
  std::uint64_t misses = 0;
  for (unsigned variant = 0; variant < 72; ++variant) {
    static constexpr AccelKind kKinds[] = {AccelKind::tri20,       AccelKind::tlas_tri20, AccelKind::ellipsoid,
                                           AccelKind::tlas_sphere, AccelKind::tri80,      AccelKind::tlas_tri80};
    static constexpr unsigned kWidths[] = {6, 2, 8, 4};
    static constexpr unsigned kWarps[] = {32, 8, 16};
    const AccelKind kind = kKinds[variant % 6];
    const AccelerationStructure accel(gaussians, {kind, kWidths[variant / 6 % 4], false, variant % 5 == 4 ? 3u : 8u});
    TracerOptions options;
    options.k = 1u << variant % 5;
    options.checkpoint = variant % 7 < 4;
    options.checkpoint_capacity = variant % 7 == 3 ? 12u : 1024u;
    options.checkpoint_order = variant % 2 == 1 ? CheckpointOrder::lifo : CheckpointOrder::fifo;
    if (variant % 2 == 0 && variant % 3 != 2) options.checkpoint_bins = variant % 4 == 0 ? 8 : 2;
    options.below_instance = variant % 10 < 4 ? BelowInstance::finish : BelowInstance::checkpoint;
    options.child_order = variant % 11 == 7   ? ChildOrder::slot
                          : variant % 11 == 3 ? ChildOrder::vulkan_sim
                                              : ChildOrder::near_first;
    options.pop_test = variant % 13 < 4 ? PopTest::off : PopTest::on;
    options.tmax_update = variant % 4 == 3 ? TmaxUpdate::kth : TmaxUpdate::reported;
    options.replay_tmax = variant % 8 == 3 ? ReplayTmax::kth : ReplayTmax::infinity;
    options.ert = variant % 3 == 1 ? 0.0f : 0.001f;
    if (!options.checkpoint && variant % 9 > 5) options.tracing = variant % 9 == 6 ? Tracing::single : Tracing::closest;
    if (options.tracing == Tracing::single && variant % 4 == 1) options.tracing = Tracing::list;
    if (options.tracing == Tracing::closest) options.k = 1;
    if (!options.checkpoint && options.tracing == Tracing::multi) {
      options.any_hit = variant % 2 == 0 ? AnyHit::delayed : AnyHit::immediate;
    }
    if (!options.checkpoint && options.tracing == Tracing::multi && options.any_hit == AnyHit::immediate &&
        !traces::is_two_level(kind)) {
      options.ahead = 1 + variant % 7;
    }
    if (options.tracing != Tracing::list && variant % 5 == 2) options.ert_check = ErtCheck::round;
    RenderOptions render{.linear_mapping = variant % 5 == 1, .warp_size = kWarps[variant % 3]};
    // From within the scene, and from where a part of the rays miss it.
    const Camera camera = test::front_camera(12, 12, variant % 4 == 2 ? 30.0 : 1.2);
    SCOPED_TRACE(accel_name(kind) + " variant " + std::to_string(variant));
    const RecordedSums sums = compare(scene, gaussians, accel, camera, options, render);
    add_totals(all, sums.totals);
    misses += sums.misses;
  }
  // All kinds of events were among them.
  EXPECT_GT(all.visits_internal, 0u);
  EXPECT_GT(all.visits_instance, 0u);
  EXPECT_GT(all.visits_leaf, 0u);
  EXPECT_GT(all.culls, 0u);
  EXPECT_GT(all.checkpoints_read, 0u);
  EXPECT_GT(all.overflows, 0u);
  EXPECT_GT(misses, 0u);
}

TEST(EncodingRecorder, LeavesTheNearestOrderToEvents) {
  traces::Header header;
  for (const auto order : {CheckpointOrder::fifo, CheckpointOrder::lifo}) {
    header.checkpoint_order = order;
    EXPECT_TRUE(EncodingRecorder::can_record(header));
  }
  header.checkpoint_order = CheckpointOrder::nearest;
  EXPECT_FALSE(EncodingRecorder::can_record(header));
}

}  // namespace
}  // namespace grtx::frontend
