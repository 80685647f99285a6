// SPDX-License-Identifier: Apache-2.0
// A layout decides which bytes a ray reads, never which Gaussians it hits: images of all layouts are equal to the bit,
// under every setting that meets another part of the traversal.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "frontend/tracer/random_scene.h"
#include "frontend/tracer/render_helpers.h"
#include "grtx/frontend/image/image.h"
#include "grtx/frontend/scene/scene_io.h"
#include "grtx/frontend/synth/synth.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/traces/check.h"
#include "grtx/traces/reader.h"
#include "grtx/traces/writer.h"

namespace grtx::frontend {
namespace {

struct LayoutView {
  Scene scene;
  Camera camera;
};

LayoutView generated(const std::string& preset, std::uint64_t count) {
  const std::string path =
      (std::filesystem::temp_directory_path() / ("grtx_layout_" + std::to_string(::getpid()) + ".ply")).string();
  synthesise({preset, count, 3, 1}, path);
  const std::string cameras = std::filesystem::path(path).replace_extension(".cameras.json").string();
  LayoutView view{load_scene(path), load_cameras(cameras)[0].resized(16, 16)};
  std::filesystem::remove(path);
  std::filesystem::remove(cameras);
  return view;
}

class LayoutInvariance : public ::testing::TestWithParam<std::tuple<AccelKind, NodeLayout>> {
 protected:
  AccelKind accel() const { return std::get<0>(GetParam()); }
  NodeLayout layout() const { return std::get<1>(GetParam()); }
  unsigned widest() const { return layout() == NodeLayout::quantised ? 6 : 8; }
  PreparedGaussians prepared(const Scene& scene) const { return {scene, true, is_quantised(layout())}; }

  void expect_same_images(const LayoutView& view) {
    const PreparedGaussians gaussians = prepared(view.scene);
    const AccelerationStructure plain(gaussians, {accel(), 6, false});
    for (const unsigned width : {widest(), 4u}) {
      const AccelerationStructure other(gaussians, {accel(), width, false, width == 4 ? 5u : 8u, layout()});
      for (unsigned setting = 0; setting < 6; ++setting) {
        TracerOptions options;
        options.k = setting < 3 ? 8u : 3u;
        options.checkpoint = setting % 2 == 1;
        if (setting == 3) options.child_order = ChildOrder::slot;
        if (setting == 4) options.walk_blas = false;
        if (setting == 5) options.checkpoint_capacity = 9;  // overflows
        const RenderResult expected = test::trace_scene(view.scene, view.camera, plain, gaussians, options);
        const RenderResult result = test::trace_scene(view.scene, view.camera, other, gaussians, options);
        EXPECT_EQ(compare(expected.image, result.image).different_pixels, 0u) << "width " << width << ' ' << setting;
        EXPECT_TRUE(expected.sequences == result.sequences) << "width " << width << " setting " << setting;
        EXPECT_EQ(expected.counters.blended, result.counters.blended);
        EXPECT_GT(result.counters.blended, 0u);
      }
    }
  }
};

TEST_P(LayoutInvariance, OfScenesLikeTrainedOnes) { expect_same_images(generated("flat", 3000)); }
TEST_P(LayoutInvariance, OfNeedlesAndFlakes) { expect_same_images(generated("stress-needles", 300)); }
TEST_P(LayoutInvariance, OfCopies) { expect_same_images(generated("stress-copies", 120)); }
TEST_P(LayoutInvariance, OfAxisParallelRays) { expect_same_images(generated("stress-axis", 600)); }
TEST_P(LayoutInvariance, OfLargeCoordinates) { expect_same_images(generated("stress-far", 300)); }

// The leaves hold the same vertices, so their own test finds the same Gaussians; t may differ in its last bits, for a
// triangle's vertices may come in another order.
TEST_P(LayoutInvariance, StoredTrianglesHitTheSameGaussians) {
  if (proxy_of(accel()) == ProxyKind::sphere) GTEST_SKIP() << "no triangles";
  const LayoutView view = generated("flat", 3000);
  const PreparedGaussians gaussians = prepared(view.scene);
  TracerOptions options;
  options.triangle_test = TriangleTest::world;
  options.ert = 0.0f;  // every hit of a ray
  const AccelerationStructure plain(gaussians, {accel(), 6, false});
  const AccelerationStructure other(gaussians, {accel(), widest(), false, 8, layout()});
  RenderResult expected = test::trace_scene(view.scene, view.camera, plain, gaussians, options);
  RenderResult result = test::trace_scene(view.scene, view.camera, other, gaussians, options);
  for (auto* sequences : {&expected.sequences, &result.sequences}) {
    for (auto& ray : *sequences) std::sort(ray.begin(), ray.end());
  }
  std::size_t different = 0;
  for (std::size_t i = 0; i < expected.sequences.size(); ++i) different += expected.sequences[i] != result.sequences[i];
  EXPECT_LE(different, expected.sequences.size() / 200);
}

TEST_P(LayoutInvariance, TracesAreConsistent) {
  const LayoutView view = generated("flat", 3000);
  const PreparedGaussians gaussians = prepared(view.scene);
  const AccelerationStructure structure(gaussians, {accel(), widest(), false, 8, layout()});
  const std::string path =
      (std::filesystem::temp_directory_path() / ("grtx_layout_" + std::to_string(::getpid()) + ".grtx")).string();
  for (const bool checkpoint : {false, true}) {
    TracerOptions options;
    options.checkpoint = checkpoint;
    RenderOptions render_options{.threads = 1};
    traces::Writer writer(path, trace_header(view.scene, view.camera, structure, options, render_options));
    const RenderResult result = render(view.scene, gaussians, structure, view.camera, options, render_options, &writer);
    writer.finish();
    const traces::Reader reader(path);
    EXPECT_EQ(reader.header().layout, layout());
    EXPECT_EQ(reader.header().node_image_bytes, structure.image().size());
    EXPECT_EQ(reader.totals().visits(), result.counters.visits());
    EXPECT_EQ(traces::check(reader, true), reader.totals());  // throws at the first violation
    std::filesystem::remove(path);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Structures, LayoutInvariance,
    ::testing::Combine(::testing::Values(AccelKind::tri20, AccelKind::tri80, AccelKind::ellipsoid,
                                         AccelKind::tlas_tri20, AccelKind::tlas_tri80, AccelKind::tlas_sphere),
                       ::testing::Values(NodeLayout::compact, NodeLayout::compressed, NodeLayout::quantised)),
    [](const auto& test) {
      std::string name = accel_name(std::get<0>(test.param)) + "_" + std::string(name_of(std::get<1>(test.param)));
      std::replace(name.begin(), name.end(), '-', '_');
      return name;
    });

}  // namespace
}  // namespace grtx::frontend
