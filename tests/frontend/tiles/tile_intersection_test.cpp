// SPDX-License-Identifier: Apache-2.0
// The tests of tile tracing never turn away what a ray hits: a Gaussian's outline, the boxes of a node. And they turn
// away most of the rest, on every path of vector instructions.
#include "grtx/frontend/tiles/tile_intersection.h"

#include <gtest/gtest.h>

#include <random>

#include "frontend/tracer/random_scene.h"

namespace grtx::frontend {
namespace {

struct Shape {
  const char* name;
  double log_scale_mean, log_scale_sd;
  double extent;
  double far;      ///< of the camera from the middle of the scene
  bool selective;  ///< the outline should turn rays away
};

// From round to a million times as long as thick, from pixels to the whole view, near and far.
constexpr Shape kShapes[] = {
    {"round", -3.0, 0.1, 1.0, 4.0, true},
    {"usual", -3.0, 1.0, 1.0, 4.0, true},
    {"needles", -3.0, 3.0, 1.0, 4.0, false},
    {"extreme needles", -3.0, 6.0, 1.0, 4.0, false},
    {"specks", -9.0, 1.0, 1.0, 4.0, true},
    {"far specks", -6.0, 1.0, 1.0, 3000.0, false},
    {"around the camera", 0.5, 1.0, 1.0, 0.1, false},
    {"huge", 8.0, 2.0, 1000.0, 500.0, false},
    {"tiny numbers", -30.0, 1.0, 1e-9, 1e-8, false},
};

Camera view(const Shape& shape, unsigned index) {
  Camera camera = test::front_camera(64, 64, shape.far);
  camera = index % 3 == 0 ? camera.fov_scaled(0.1) : index % 3 == 1 ? camera : camera.fov_scaled(3.0);
  const double turn = 0.7 * index;  // so that no axis of the world is one of the view
  const glm::dmat3 about_y(std::cos(turn), 0.0, -std::sin(turn), 0.0, 1.0, 0.0, std::sin(turn), 0.0, std::cos(turn));
  const glm::dmat3 about_x(1.0, 0.0, 0.0, 0.0, std::cos(0.3), std::sin(0.3), 0.0, -std::sin(0.3), std::cos(0.3));
  camera.rotation = about_y * about_x;
  camera.position = camera.rotation * glm::dvec3(0.0, 0.0, -shape.far);
  return index % 5 == 4 ? camera.as_fisheye(2.0) : camera;
}

TEST(TileTests, OutlineHoldsEveryRayWithinTheRadius) {
  for (const Shape& shape : kShapes) {
    const Scene scene = test::random_scene(61, {150, shape.extent, shape.log_scale_mean, shape.log_scale_sd});
    const PreparedGaussians gaussians(scene, true);
    const TileStructure structure(scene, gaussians, ProxyKind::sphere);
    for (const SimdPath path : available_simd_paths()) {
      SCOPED_TRACE(simd_path_name(path));
      std::uint64_t within = 0, left = 0, all = 0;
      for (unsigned index = 0; index < 10; ++index) {
        const Camera camera = view(shape, index);
        for (const unsigned corner : {0u, 24u, 56u}) {
          const TileRays tile(camera, glm::vec3(camera.position), corner, 24);
          // In batches of every size.
          for (std::uint32_t g = 0, size = 1; g < scene.size(); g += size, size = size % 19 + 1) {
            std::vector<TileCandidate> candidates;
            for (std::uint32_t i = g; i < std::min<std::size_t>(scene.size(), g + size); ++i) {
              candidates.push_back({0xFF, i});
            }
            tile_tests(path).outlines(structure, tile, candidates.data(), candidates.size());
            for (const TileCandidate& candidate : candidates) {
              std::uint64_t expected = 0;
              for (unsigned r = 0; r < kTileRays; ++r) {
                const std::uint32_t id = structure.gaussian(candidate.gaussian).id;
                expected |= std::uint64_t{to_unit_ray(tile.rays[r], gaussians.record(id)).d2 <= 1.0f} << r;
              }
              EXPECT_EQ(expected & ~candidate.rays, 0u)
                  << shape.name << " view " << index << " Gaussian " << candidate.gaussian;
              within += static_cast<std::uint64_t>(std::popcount(expected));
              left += static_cast<std::uint64_t>(std::popcount(candidate.rays));
              all += kTileRays;
            }
          }
        }
      }
      if (shape.selective) {
        EXPECT_LT(left - within, all / 100) << shape.name;
      }
    }
  }
}

TEST(TileTests, NodeHoldsEveryBoxThatARayMeets) {
  for (const Shape& shape : kShapes) {
    const Scene scene = test::random_scene(62, {300, shape.extent, shape.log_scale_mean, shape.log_scale_sd});
    const PreparedGaussians gaussians(scene, true);
    const TileStructure structure(scene, gaussians, ProxyKind::icosahedron20);
    TileDepths depths{.first = std::bit_cast<std::int32_t>(static_cast<float>(0.5 * shape.far)), .shift = 17};
    for (const SimdPath path : available_simd_paths()) {
      SCOPED_TRACE(simd_path_name(path));
      std::uint64_t met_boxes = 0, all = 0;
      for (unsigned index = 0; index < 10; ++index) {
        const Camera camera = view(shape, index);
        const TileRays tile(camera, glm::vec3(camera.position), 40, 16);
        for (std::uint32_t n = 0; n < structure.nodes(); ++n) {
          const TileNode& node = structure.node(n);
          TileNodeHits hits;
          const unsigned met = tile_tests(path).node(node, tile, depths, 0, hits);
          EXPECT_EQ(met & ~node.used, 0u);
          for (unsigned slot = 0; slot < kTileNodeWidth && (node.used >> slot & 1) != 0; ++slot) {
            const Box box = node.box(slot);
            ++all;
            met_boxes += met >> slot & 1;
            for (unsigned r = 0; r < kTileRays; ++r) {
              const Interval interval = conservative_interval(tile.rays[r].slabs, box);
              if (interval.empty()) continue;
              ASSERT_NE(met >> slot & 1, 0u) << shape.name << " view " << index << " node " << n;
              EXPECT_NE(hits.vectors[slot] >> (r / kTileLanes) & 1, 0u) << shape.name << " view " << index;
              EXPECT_LE(hits.bucket[slot], depths.bucket_of(interval.enter)) << shape.name << " view " << index;
            }
          }
        }
      }
      if (shape.selective) {
        EXPECT_LT(met_boxes, all / 4) << shape.name;
      }
    }
  }
}

TEST(TileTests, BucketsGrowWithDepth) {
  TileDepths depths{.first = std::bit_cast<std::int32_t>(2.0f), .shift = 19};
  EXPECT_EQ(depths.bucket_of(0.0f), 0u);
  EXPECT_EQ(depths.bucket_of(1.99f), 0u);
  EXPECT_EQ(depths.bucket_of(2.0f), 1u);
  EXPECT_EQ(depths.bucket_of(4.0f), 17u);  // sixteen to an octave
  EXPECT_EQ(depths.bucket_of(1e38f), TileDepths::kBuckets - 1);
  unsigned last = 0;
  for (float t = 0.01f; t < 1e30f; t *= 1.01f) {
    EXPECT_GE(depths.bucket_of(t), last);
    last = depths.bucket_of(t);
  }
}

}  // namespace
}  // namespace grtx::frontend
