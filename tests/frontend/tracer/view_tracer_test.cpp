// SPDX-License-Identifier: Apache-2.0
// One class from scene to image and trace: the same as its steps by hand, for one structure after the other.
#include "grtx/frontend/tracer/view_tracer.h"
#include "grtx/frontend/tracer/tracer.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <stdexcept>

#include "frontend/scene/scene_bytes.h"
#include "frontend/tracer/random_scene.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/frontend/image/image.h"
#include "grtx/traces/reader.h"
#include "grtx/traces/writer.h"

namespace grtx::frontend {
namespace {

RenderOptions one_thread() {
  RenderOptions render{.threads = 1};
  return render;
}

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(ViewTracer, GivesWhatItsStepsGive) {
  const Scene scene = grtx::test::random_scene(71);
  const Camera camera = grtx::test::front_camera(24, 16);
  ViewTracer view(scene, camera);
  for (const AccelKind kind : {AccelKind::tri20, AccelKind::tlas_tri20}) {
    view.build({kind});
    for (const bool checkpoint : {false, true}) {
      TracerOptions options;
      options.checkpoint = checkpoint;
      const test::TemporaryPath expected_file(".grtx"), file(".grtx");
      const PreparedGaussians gaussians(scene, true);
      const AccelerationStructure accel(gaussians, {kind});
      traces::Header header = trace_header(scene, camera, accel, options, one_thread());
      header.inputs["word"] = "text";
      traces::Writer writer(expected_file.str(), header);
      const RenderResult expected = render(scene, gaussians, accel, camera, options, one_thread(), &writer);
      writer.finish();
      const TracedView traced = view.trace(options, one_thread(), file.str(), {{"word", "text"}});
      EXPECT_TRUE(compare(expected.image, traced.result.image).identical());
      EXPECT_EQ(expected.counters.visits(), traced.result.counters.visits());
      EXPECT_EQ(bytes_of(file.str()), bytes_of(expected_file.str()));
      EXPECT_EQ(traced.inputs, header.inputs);
      EXPECT_EQ(traces::Reader(file.str()).header().inputs, header.inputs);
      ASSERT_TRUE(traced.trace.has_value());
      EXPECT_EQ(traced.trace->bytes, writer.bytes());
      EXPECT_EQ(traced.trace->visits, writer.totals().visits());
    }
  }
}

TEST(ViewTracer, ASequenceIsItsFramesOneAfterTheOther) {
  const Scene scene = grtx::test::random_scene(78);
  Camera second = grtx::test::front_camera(24, 16);
  second.position.x += 0.05;
  const std::vector<Camera> cameras = {grtx::test::front_camera(24, 16), second};
  TracerOptions options;
  options.checkpoint = true;
  RenderOptions render = one_thread();
  render.count_hits = true;
  const test::TemporaryPath sequence_file(".grtx");
  ViewTracer sequence(scene, cameras);
  sequence.build({AccelKind::tlas_tri20});
  const TracedView traced = sequence.trace(options, render, sequence_file.str());
  const traces::Reader reader(sequence_file.str());
  const auto& inputs = reader.header().inputs;
  EXPECT_EQ(inputs.at("camera_hash"), hex(xxh3(hex(cameras[0].hash()) + hex(cameras[1].hash()))));
  EXPECT_EQ(inputs.at("fov_scale"), "1");
  ASSERT_EQ(traced.further.size(), 1u);
  ASSERT_EQ(reader.header().frame_groups, (std::vector<std::uint64_t>{12, 12}));
  std::uint64_t visits = 0, hits = 0;
  for (std::uint32_t f = 0; f < 2; ++f) {
    const test::TemporaryPath file(".grtx");
    ViewTracer one(scene, cameras[f]);
    one.build({AccelKind::tlas_tri20});
    const TracedView frame = one.trace(options, render, file.str());
    const Image& image = f == 0 ? traced.result.image : traced.further[0];
    EXPECT_TRUE(compare(image, frame.result.image).identical());
    visits += frame.result.counters.visits();
    hits += frame.result.counters.hits.value();
    const traces::Reader alone(file.str());
    ASSERT_EQ(alone.group_count(), 12u);
    for (std::uint32_t g = 0; g < 12; ++g) {
      traces::RayGroup expected, group;
      alone.read(g, expected);
      reader.read(12 * f + g, group);
      expected.index = 12 * f + g;
      expected.frame = f;
      EXPECT_EQ(group, expected);
    }
  }
  EXPECT_EQ(traced.result.counters.visits(), visits);
  EXPECT_EQ(traced.result.counters.hits.value(), hits);
  EXPECT_THROW(ViewTracer(scene, {cameras[0], grtx::test::front_camera(16, 16)}), Error);
}

TEST(ViewTracer, ASceneOrCameraOfTheSameNameInInputsDoesNotHideTheViews) {
  ViewTracer view(grtx::test::random_scene(72), grtx::test::front_camera(4, 4));
  view.build({});
  const TracedView traced = view.trace({}, one_thread(), "", {{"scene_hash", "another"}});
  EXPECT_EQ(traced.inputs.at("scene_hash"), view.scene().hash);
  EXPECT_FALSE(traced.trace.has_value());
}

TEST(ViewTracer, KeepsAStructureOfTheSameOptions) {
  ViewTracer view(grtx::test::random_scene(73), grtx::test::front_camera(4, 4));
  const std::uint8_t* const nodes = view.build({AccelKind::tlas_tri20}).image().node(0);
  EXPECT_EQ(view.build({AccelKind::tlas_tri20}).image().node(0), nodes);
  EXPECT_EQ(view.build({AccelKind::tlas_tri20, 4}).options().width, 4u);
}

TEST(ViewTracer, LooksFromElsewhereWithoutBuilding) {
  const Scene scene = grtx::test::random_scene(79);
  Camera other = grtx::test::front_camera(16, 24);
  other.position.x += 0.05;
  ViewTracer view(scene, grtx::test::front_camera(24, 16));
  view.build({AccelKind::tlas_tri20});
  view.trace({}, one_thread());
  view.look({other});
  view.build({AccelKind::tlas_tri20});
  EXPECT_EQ(view.structures_built(), 1u);
  ViewTracer alone(scene, other);
  alone.build({AccelKind::tlas_tri20});
  const test::TemporaryPath file(".grtx"), expected(".grtx");
  const TracedView traced = view.trace({}, one_thread(), file.str());
  EXPECT_TRUE(compare(traced.result.image, alone.trace({}, one_thread(), expected.str()).result.image).identical());
  EXPECT_EQ(bytes_of(file.str()), bytes_of(expected.str()));
  view.build({AccelKind::tri20});
  EXPECT_EQ(view.structures_built(), 2u);
  EXPECT_THROW(view.look({other, grtx::test::front_camera(24, 16)}), Error);
}

TEST(ViewTracer, TracesSecondaryRaysOfWhatIsPlaced) {
  ViewTracer view(grtx::test::random_scene(74), grtx::test::front_camera(24, 24));
  view.build({AccelKind::tlas_tri20});
  EXPECT_TRUE(view.trace({}, one_thread()).plan.rays.empty());
  OpticalObjects objects;
  objects.glass = make_glass({0.0, 0.0, 0.0}, 0.5, 1.5);
  view.place(objects);
  const TracedView traced = view.trace({}, one_thread());
  EXPECT_FALSE(traced.plan.rays.empty());
  EXPECT_EQ(traced.result.secondary.rays, traced.plan.rays.size());
}

TEST(ViewTracer, RefusesToTraceWithoutStructureOrWithAnotherRadius) {
  ViewTracer view(grtx::test::random_scene(75), grtx::test::front_camera(4, 4));
  EXPECT_THROW(view.trace({}, one_thread()), std::logic_error);
  view.build({});
  TracerOptions options{.kernel = {false}};
  EXPECT_THROW(view.trace(options, one_thread()), std::logic_error);
}

}  // namespace
}  // namespace grtx::frontend
