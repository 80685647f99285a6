// SPDX-License-Identifier: Apache-2.0
// Layout quantised: the 32 B of a leaf, bit for bit (docs/model/node-image.md), what they keep of a Gaussian, and that
// a structure holds what the tracer draws. How far images are from the reference: quantised_image_test.cpp.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <glm/mat3x3.hpp>
#include <random>

#include "frontend/tracer/random_scene.h"
#include "grtx/frontend/accel/acceleration_structure.h"

namespace grtx::frontend {
namespace {

// Bits [first, first + count) of the leaf, as one would write them down.
std::uint64_t bits(const QuantisedGaussian& leaf, unsigned first, unsigned count) {
  std::uint64_t value = 0;
  for (unsigned i = 0; i < count; ++i) {
    const unsigned bit = first + i;
    value |= std::uint64_t{leaf.words()[bit / 32] >> (bit % 32) & 1u} << i;
  }
  return value;
}

TEST(QuantisedLayout, LeafBitByBit) {
  const MeanGrid grid{{-1.0f, 0.0f, 8.0f}, {0.5f, 0.25f, 1.0f}};
  const glm::dvec3 rows[3] = {{1.0, -0.5, 0.0}, {0.0, 3.0, 0.75}, {0.0, 0.0, -0.125}};
  const QuantisedGaussian leaf(grid, 0x2ABCDEF, 0.4f, {1.5f, 1.0f, 11.0f}, rows);
  EXPECT_EQ(bits(leaf, 0, 26), 0x2ABCDEFu);
  EXPECT_EQ(bits(leaf, 26, 8), 102u);  // 0.4 * 255
  EXPECT_EQ(bits(leaf, 34, 22), 5u);
  EXPECT_EQ(bits(leaf, 56, 22), 4u);
  EXPECT_EQ(bits(leaf, 78, 22), 3u);
  // Entries are multiples of 2^(exponent - 14) below 2^exponent: 1 = 8192 * 2^(1 - 14).
  EXPECT_EQ(bits(leaf, 100, 7), 81u);
  EXPECT_EQ(bits(leaf, 107, 15), 8192u);
  EXPECT_EQ(bits(leaf, 122, 15), 32768u - 4096u);
  EXPECT_EQ(bits(leaf, 137, 15), 0u);
  EXPECT_EQ(bits(leaf, 152, 7), 82u);
  EXPECT_EQ(bits(leaf, 159, 15), 0u);
  EXPECT_EQ(bits(leaf, 174, 15), 12288u);
  EXPECT_EQ(bits(leaf, 189, 15), 3072u);
  EXPECT_EQ(bits(leaf, 204, 7), 78u);
  EXPECT_EQ(bits(leaf, 241, 15), 32768u - 8192u);

  EXPECT_EQ(leaf.id(), 0x2ABCDEFu);
  EXPECT_FLOAT_EQ(leaf.opacity(), 0.4f);
  EXPECT_EQ(leaf.mean(grid), glm::vec3(1.5f, 1.0f, 11.0f));
  for (unsigned i = 0; i < 3; ++i) EXPECT_EQ(leaf.row(i), glm::vec3(rows[i]));
}

TEST(QuantisedLayout, ErrorsStayWithinHalfAStep) {
  std::mt19937 engine(17);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  std::vector<glm::vec3> means;
  for (unsigned i = 0; i < 2000; ++i) means.emplace_back(uniform(-50, 3), uniform(0.1, 0.2), uniform(900, 5000));
  const MeanGrid grid = MeanGrid::covering(means);
  for (std::uint32_t i = 0; i < means.size(); ++i) {
    const double size = std::exp2(uniform(-70, 40));
    glm::dvec3 rows[3];
    for (glm::dvec3& row : rows) row = {uniform(-size, size), uniform(-size, size), uniform(-size, size)};
    const auto opacity = static_cast<float>(uniform(0.0, 1.0));
    const QuantisedGaussian leaf(grid, i, opacity, means[i], rows);
    EXPECT_NEAR(leaf.opacity(), opacity, 0.5 / 255 + 1e-7);
    EXPECT_EQ(leaf.opacity(), QuantisedGaussian::nearest_opacity(opacity));
    for (int axis = 0; axis < 3; ++axis) {
      // Half a step, and the rounding of the sum to fp32.
      const double rounding = std::fabs(static_cast<double>(means[i][axis])) / (1 << 24);
      EXPECT_NEAR(leaf.mean(grid)[axis], means[i][axis], 0.5 * static_cast<double>(grid.step[axis]) + rounding);
    }
    for (unsigned k = 0; k < 3; ++k) {
      const glm::dvec3& row = rows[k];
      const double largest = std::max({std::fabs(row.x), std::fabs(row.y), std::fabs(row.z)});
      for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(leaf.row(k)[axis], row[axis], largest / (1 << 14));
    }
  }
}

// What no code holds: means off the grid, rows beyond the exponents, sums that overflow.
TEST(QuantisedLayout, CodesThatHoldNoGaussian) {
  const MeanGrid grid{{-1.0f, 0.0f, 8.0f}, {0.5f, 0.25f, 1.0f}};
  const glm::dvec3 rows[3] = {{1.0, -0.5, 0.0}, {0.0, 3.0, 0.75}, {0.0, 0.0, -0.125}};
  EXPECT_TRUE(QuantisedGaussian::holds(grid, {1.5f, 1.0f, 11.0f}, rows));
  EXPECT_FALSE(QuantisedGaussian::holds(grid, {-1.5f, 1.0f, 11.0f}, rows));
  EXPECT_FALSE(QuantisedGaussian::holds(grid, {1.5f, 0x1p20f, 11.0f}, rows));
  const float infinity = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(QuantisedGaussian::holds(grid, {infinity, 1.0f, 11.0f}, rows));
  EXPECT_FALSE(QuantisedGaussian::holds(grid, {std::nanf(""), 1.0f, 11.0f}, rows));
  const MeanGrid vast{glm::vec3(-3e38f), glm::vec3(0x1p106f)};
  EXPECT_FALSE(QuantisedGaussian::holds(vast, glm::vec3(3e38f), rows));
  for (const double wrong : {0x1p-90, 0x1p60, 0.0}) {
    const glm::dvec3 beyond[3] = {rows[0], {0.0, wrong, 0.0}, rows[2]};
    EXPECT_FALSE(QuantisedGaussian::holds(grid, {1.5f, 1.0f, 11.0f}, beyond)) << wrong;
  }
}

// A row beyond the exponents keeps its direction; its length is the nearest that there is.
TEST(QuantisedLayout, ExtremeScalesKeepTheirDirection) {
  const glm::dvec3 rows[3] = {{std::exp2(-90), 0.0, -std::exp2(-91)}, {0.0, std::exp2(60), 0.0}, {1.0, 1.0, 1.0}};
  const QuantisedGaussian leaf({}, 0, 1.0f, {}, rows);
  EXPECT_EQ(leaf.row(0).z / leaf.row(0).x, -0.5f);
  EXPECT_EQ(leaf.row(0).x, std::exp2(-81.0f));
  EXPECT_EQ(leaf.row(1), glm::vec3(0.0f, std::exp2(46.0f), 0.0f));
}

TEST(QuantisedLayout, LeavesHoldWhatIsDrawn) {
  const Scene scene = test::random_scene(6);
  const PreparedGaussians gaussians(scene, true, true);
  for (const auto kind : {AccelKind::ellipsoid, AccelKind::tlas_tri20, AccelKind::tlas_sphere}) {
    const AccelerationStructure accel(gaussians, {kind, 6, false, 8, NodeLayout::quantised});
    const NodeImage& image = accel.image();
    const NodeKind leaves = is_two_level(kind) ? NodeKind::instance : NodeKind::procedural;
    std::vector<unsigned> seen(scene.size());
    std::vector<std::uint64_t> nodes{accel.root()};
    while (!nodes.empty()) {
      const DecodedInternal node = image.decode_internal(nodes.back());
      nodes.pop_back();
      std::uint64_t at = node.child_base;
      for (unsigned i = 0; i < node.child_count; ++i) {
        if (node.kinds[i] == NodeKind::internal) {
          nodes.push_back(at);
        } else {
          ASSERT_EQ(node.kinds[i], leaves);
          const QuantisedGaussian leaf = image.quantised_gaussian(at);
          const GaussianRecord& record = gaussians.record(leaf.id());
          ++seen.at(leaf.id());
          EXPECT_EQ(image.leaf_index(static_cast<std::uint32_t>(at / 32)), leaf.id());
          EXPECT_EQ(leaf.opacity(), record.opacity);
          EXPECT_EQ(leaf.mean(gaussians.mean_grid()), record.mean);
          for (unsigned axis = 0; axis < 3; ++axis) EXPECT_EQ(leaf.row(axis), record.to_unit[axis]);
          const Box inside = gaussians.instance_box(leaf.id(), accel.proxy(), false);
          for (int axis = 0; axis < 3; ++axis) {
            EXPECT_LE(node.boxes[i].lower[axis], inside.lower[axis]);
            EXPECT_GE(node.boxes[i].upper[axis], inside.upper[axis]);
          }
        }
        at += image.sizes().bytes(node.kinds[i]);
      }
    }
    EXPECT_EQ(seen, std::vector<unsigned>(scene.size(), 1)) << accel_name(kind);
    const auto& counts = accel.counts();
    EXPECT_EQ(image.size(), 64 * (is_two_level(kind) ? 2 : 1) + 64 * counts.internal +
                                32 * (counts.instance + counts.procedural) +
                                (kind == AccelKind::tlas_tri20 ? 64 : 0) * counts.blas_nodes +
                                (kind == AccelKind::tlas_sphere ? 64 + 32 : 0))
        << accel_name(kind);
  }
}

// The child byte of the parent says that a leaf is wide; its 64 B are those of an ellipsoid of layout vulkan_sim, or of
// an instance of layout compressed.
TEST(QuantisedLayout, WideLeavesHoldTheWholeGaussian) {
  Scene scene = test::random_scene(6);
  for (std::size_t g = 0; g < scene.size(); ++g) {
    if (g % 7 == 0) scene.mean[g] *= 1e6f;
  }
  const PreparedGaussians gaussians(scene, true, true), whole(scene, true);
  ASSERT_GE(gaussians.wide_count(), scene.size() / 7);
  ASSERT_LT(gaussians.wide_count(), scene.size() / 2);
  for (const auto kind : {AccelKind::ellipsoid, AccelKind::tlas_tri20, AccelKind::tlas_sphere}) {
    const AccelerationStructure accel(gaussians, {kind, 6, false, 8, NodeLayout::quantised});
    const NodeImage& image = accel.image();
    const auto fp32 = [&](std::uint64_t at) { return std::bit_cast<float>(image.read_u32(at)); };
    std::vector<unsigned> seen(scene.size());
    std::vector<std::uint64_t> nodes{accel.root()};
    while (!nodes.empty()) {
      const DecodedInternal node = image.decode_internal(nodes.back());
      nodes.pop_back();
      std::uint64_t at = node.child_base;
      for (unsigned i = 0; i < node.child_count; ++i) {
        if (node.kinds[i] == NodeKind::internal) {
          nodes.push_back(at);
        } else {
          const std::uint32_t g = image.leaf_index(static_cast<std::uint32_t>(at / 32));
          ++seen.at(g);
          EXPECT_EQ(traces::is_wide(node.kinds[i]), gaussians.wide(g));
          if (gaussians.wide(g)) {
            const std::uint64_t map = is_two_level(kind) ? at : at + 16;
            EXPECT_EQ(image.read_u32(is_two_level(kind) ? at + 56 : at + 12), g);
            for (unsigned f = 0; f < 12; ++f) {
              const int axis = static_cast<int>(f % 3);
              const glm::vec3& from = f < 9 ? whole.record(g).to_unit[f / 3] : whole.record(g).mean;
              EXPECT_EQ(fp32(map + 4 * f), from[axis]);
            }
            EXPECT_EQ(gaussians.record(g).opacity, scene.opacity[g]);
          } else {
            EXPECT_EQ(image.quantised_gaussian(at).id(), g);
          }
        }
        at += image.sizes().bytes(node.kinds[i]);
      }
    }
    EXPECT_EQ(seen, std::vector<unsigned>(scene.size(), 1)) << accel_name(kind);
    EXPECT_EQ(accel.counts().wide, gaussians.wide_count());
    const auto& counts = accel.counts();
    EXPECT_EQ(image.size(), 64 * (is_two_level(kind) ? 2 : 1) + 64 * counts.internal +
                                32 * (counts.instance + counts.procedural + counts.wide) +
                                (kind == AccelKind::tlas_tri20 ? 64 : 0) * counts.blas_nodes +
                                (kind == AccelKind::tlas_sphere ? 64 + 32 : 0))
        << accel_name(kind);
  }
}

// Maps to the unit sphere and back are inverse to each other, whatever was rounded.
TEST(QuantisedLayout, HalfAxesFitTheRoundedMap) {
  const Scene scene = test::random_scene(7);
  const PreparedGaussians gaussians(scene, true, true);
  for (std::uint32_t g = 0; g < gaussians.size(); ++g) {
    const GaussianRecord& record = gaussians.record(g);
    for (int axis = 0; axis < 3; ++axis) {
      const glm::dvec3 half_axis = gaussians.half_axis(g, axis);
      for (int row = 0; row < 3; ++row) {
        const glm::dvec3 to_unit = record.to_unit[row];
        const double scale = glm::length(to_unit) * glm::length(half_axis);
        EXPECT_NEAR(glm::dot(to_unit, half_axis), row == axis ? 1.0 : 0.0, 1e-6 * std::max(scale, 1.0));
      }
    }
  }
}

}  // namespace
}  // namespace grtx::frontend
