// SPDX-License-Identifier: Apache-2.0
// Tile tracing gives the image of --tracing multi, bit for bit: for every proxy, option and camera, any number of
// threads and every path of vector instructions.
#include "grtx/frontend/tiles/tile_tracer.h"

#include <gtest/gtest.h>

#include "frontend/synth/stress_scenes.h"
#include "frontend/tracer/random_scene.h"
#include "frontend/tracer/render_helpers.h"
#include "grtx/base/error.h"
#include "grtx/frontend/image/image.h"
#include "parameter_names.h"
#include "real_scene_files.h"

namespace grtx::frontend {
namespace {

constexpr AccelKind kAllKinds[] = {AccelKind::tri20,      AccelKind::tri80,      AccelKind::ellipsoid,
                                   AccelKind::tlas_tri20, AccelKind::tlas_tri80, AccelKind::tlas_sphere};

TileResult trace_tiles(const Scene& scene, const Camera& camera, AccelKind kind, const TracerOptions& options,
                       unsigned threads = 1) {
  const PreparedGaussians gaussians(scene, options.kernel);
  const TileStructure structure(scene, gaussians, proxy_of(kind));
  RenderOptions render{.threads = threads};
  return render_tiles(scene, gaussians, structure, camera, options, render);
}

/// Returns what was blended, so that a test can ask for work.
std::uint64_t expect_same_image(const Scene& scene, const Camera& camera, AccelKind kind, TracerOptions options,
                                const std::string& what = "") {
  options.k = 64;
  const RenderResult expected = test::trace_scene(scene, camera, kind, options);
  const TileResult actual = trace_tiles(scene, camera, kind, options);
  EXPECT_EQ(compare(expected.image, actual.image).different_pixels, 0u) << accel_name(kind) << " " << what;
  EXPECT_EQ(expected.counters.blended, actual.counters.blended) << accel_name(kind) << " " << what;
  EXPECT_EQ(expected.counters.terminated, actual.counters.terminated) << accel_name(kind) << " " << what;
  EXPECT_EQ(expected.counters.rays, actual.counters.rays) << accel_name(kind) << " " << what;
  return actual.counters.blended;
}

TEST(TileTracer, GivesTheImageOfRoundsForEveryProxy) {
  for (const AccelKind kind : kAllKinds) {
    for (const unsigned seed : {41u, 42u}) {
      EXPECT_GT(expect_same_image(test::random_scene(seed), test::front_camera(40, 24), kind, {}), 1000u);
    }
  }
}

TEST(TileTracer, GivesItForEveryOption) {
  const Scene scene = test::random_scene(43, {400, 1.0, -2.2, 1.0, 0.003, 1.0, 3});
  const Camera camera = test::front_camera(24, 24);
  struct Variant {
    const char* name;
    void (*set)(TracerOptions&);
  };
  const Variant variants[] = {
      {"ert 0", [](TracerOptions& o) { o.ert = 0.0f; }},
      {"ert 0.5", [](TracerOptions& o) { o.ert = 0.5f; }},
      {"peak", [](TracerOptions& o) { o.sort_key = SortKey::peak; }},
      {"3 sigma", [](TracerOptions& o) { o.kernel = {false}; }},
      {"centre", [](TracerOptions& o) { o.sh_direction = ShDirection::centre; }},
      {"fp16", [](TracerOptions& o) { o.response_precision = ResponsePrecision::fp16; }},
      {"bf16", [](TracerOptions& o) { o.response_precision = ResponsePrecision::bf16; }},
  };
  for (const Variant& variant : variants) {
    for (const AccelKind kind : {AccelKind::tri20, AccelKind::ellipsoid}) {
      TracerOptions options;
      variant.set(options);
      EXPECT_GT(expect_same_image(scene, camera, kind, options, variant.name), 1000u);
    }
  }
  for (const SortKey key : {SortKey::entry, SortKey::peak}) {
    TracerOptions options;
    options.sort_key = key;
    options.inside = InsideRule::count;
    expect_same_image(scene, test::front_camera(24, 24, 0.2), AccelKind::tlas_sphere, options, "inside count");
  }
}

TEST(TileTracer, GivesItAtEverySizeAndPlace) {
  const Scene scene = test::random_scene(44);
  for (const auto& [width, height] : {std::pair{1u, 1u}, {8u, 8u}, {9u, 7u}, {3u, 33u}, {65u, 2u}}) {
    expect_same_image(scene, test::front_camera(width, height), AccelKind::ellipsoid, {},
                      std::to_string(width) + "x" + std::to_string(height));
  }
  for (const double distance : {0.0, 0.5, 1.0, 50.0}) {  // the first three inside the scene
    expect_same_image(scene, test::front_camera(33, 17, distance), AccelKind::tlas_sphere, {},
                      "from " + std::to_string(distance));
  }
  expect_same_image(scene, test::front_camera(17, 17, 1.0).fov_scaled(8.0), AccelKind::ellipsoid, {}, "wide");
  Camera axis = test::front_camera(17, 17);  // a ray along z, and tiles on both sides of it
  axis.position = {0.0, 0.0, -4.0};
  expect_same_image(scene, axis, AccelKind::ellipsoid, {}, "axis");
  for (const double fov : {0.5, 3.0, 6.2}) {
    expect_same_image(scene, test::front_camera(19, 19, 0.3).as_fisheye(fov), AccelKind::tri20, {}, "fisheye");
  }
}

TEST(TileTracer, GivesItForEveryDegree) {
  for (const unsigned degree : {0u, 1u, 2u, 3u, 4u}) {
    const Scene scene = test::random_scene(45, {200, 1.0, -2.0, 1.0, 0.05, 0.95, degree});
    expect_same_image(scene, test::front_camera(20, 20), AccelKind::tlas_sphere, {}, std::to_string(degree));
  }
}

TEST(TileTracer, GivesItAtEveryScale) {
  for (const int exponent : {-10, 60, 73, 110, 120}) {
    Scene scene = test::random_scene(47);
    for (std::size_t g = 0; g < scene.size(); ++g) {
      scene.mean[g] *= std::ldexp(1.0f, exponent);
      scene.scale[g] *= std::ldexp(1.0f, exponent);
    }
    Camera camera = test::front_camera(20, 20);
    camera.position *= std::ldexp(1.0, exponent);
    for (const AccelKind kind : {AccelKind::tlas_sphere, AccelKind::tri20}) {
      EXPECT_GT(expect_same_image(scene, camera, kind, {}, std::to_string(exponent)), 1000u);
    }
  }
}

TEST(TileTracer, GivesItForFewGaussiansAndNone) {
  for (const std::size_t count : {0u, 1u, 2u, 9u}) {
    expect_same_image(test::random_scene(46, {count, 0.3, -1.0, 0.5, 0.5, 0.9, 1}), test::front_camera(16, 16),
                      AccelKind::ellipsoid, {}, std::to_string(count));
  }
}

TEST(TileTracer, IsTheSameForAnyThreadsAndVectorInstructions) {
  const Scene scene = test::random_scene(47, {800, 1.0, -2.5, 1.0, 0.02, 0.95, 2});
  const Camera camera = test::front_camera(61, 43);
  const TileResult expected = trace_tiles(scene, camera, AccelKind::tlas_sphere, {});
  for (const unsigned threads : {2u, 7u}) {
    const TileResult actual = trace_tiles(scene, camera, AccelKind::tlas_sphere, {}, threads);
    EXPECT_EQ(compare(expected.image, actual.image).different_pixels, 0u) << threads;
    EXPECT_EQ(expected.counters.nodes, actual.counters.nodes) << threads;
    EXPECT_EQ(expected.counters.hits, actual.counters.hits) << threads;
  }
  for (const SimdPath path : available_simd_paths()) {
    TracerOptions options;
    options.simd = path;
    for (const AccelKind kind : {AccelKind::tri20, AccelKind::tlas_sphere}) {
      EXPECT_GT(expect_same_image(scene, camera, kind, options, simd_path_name(path)), 1000u);
    }
    const TileCounters c = trace_tiles(scene, camera, AccelKind::tlas_sphere, options).counters;
    EXPECT_EQ(expected.counters.nodes, c.nodes) << simd_path_name(path);
    EXPECT_EQ(expected.counters.gaussians, c.gaussians) << simd_path_name(path);
    EXPECT_EQ(expected.counters.candidates, c.candidates) << simd_path_name(path);
    EXPECT_EQ(expected.counters.hits, c.hits) << simd_path_name(path);
  }
}

TEST(TileTracer, SharesItsWork) {
  const Scene scene = test::random_scene(48);
  const Camera camera = test::front_camera(32, 32);
  const TileCounters c = trace_tiles(scene, camera, AccelKind::ellipsoid, {}).counters;
  EXPECT_EQ(c.tiles, 16u);
  EXPECT_EQ(c.rays, 1024u);
  EXPECT_LE(c.gaussians, 16u * scene.size());  // each at most once a tile
  EXPECT_LT(c.nodes, 1024u);
  EXPECT_GE(c.candidates, c.hits);
  EXPECT_GE(c.hits, c.blended);
  EXPECT_LE(c.hit_tests, c.candidates);
}

TEST(TileTracer, RefusesWhatItCannotDo) {
  const auto refused = [](auto&& set) {
    TracerOptions options;
    set(options);
    EXPECT_THROW(check_tile_options(options), Error);
  };
  refused([](TracerOptions& o) { o.resume = Resume::strict; });
  refused([](TracerOptions& o) { o.triangle_test = TriangleTest::world; });
  refused([](TracerOptions& o) { o.checkpoint = true; });
  EXPECT_NO_THROW(check_tile_options({}));
}

class TilesOfPreset : public testing::TestWithParam<std::string> {};

TEST_P(TilesOfPreset, GivesTheImageOfRounds) {
  const test::GeneratedScene generated = test::generated_scene(GetParam(), 1500);
  for (std::size_t view = 0; view < std::min<std::size_t>(2, generated.cameras.size()); ++view) {
    for (const AccelKind kind : {AccelKind::tlas_tri20, AccelKind::tlas_sphere}) {
      expect_same_image(generated.scene, test::small_view(generated, view, 18), kind, {}, std::to_string(view));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Presets, TilesOfPreset, testing::ValuesIn(synth_presets()), test::preset_test_name);

struct RealScene {
  const char* file;
  const char* cameras;
  friend void PrintTo(const RealScene& s, std::ostream* out) { *out << s.file; }
};
class TilesOfRealScene : public testing::TestWithParam<RealScene> {};

TEST_P(TilesOfRealScene, GivesTheImageOfRounds) {
  const std::string path = test::real_scene_path(GetParam().file);
  const std::string cameras = test::real_cameras_path(GetParam().cameras);
  if (path.empty() || cameras.empty()) {
    GTEST_SKIP() << "no real scenes: put them into ../shared/scenes or name the folder in GRTX_SCENES";
  }
  const Scene scene = load_scene(path);
  const Camera camera = load_cameras(cameras)[0].resized(60, 50);
  EXPECT_GT(expect_same_image(scene, camera, AccelKind::tlas_sphere, {}), 10000u);
}

INSTANTIATE_TEST_SUITE_P(Scenes, TilesOfRealScene,
                         testing::Values(RealScene{"statue_st-peter_sh0", "st-peter"},
                                         RealScene{"pizza_161k_sh3", "pizza"}, RealScene{"playbot_L2", "playbot"}),
                         grtx::test::PrintedName{});

}  // namespace
}  // namespace grtx::frontend
