// SPDX-License-Identifier: Apache-2.0
// Layout compressed, byte for byte (docs/model/node-image.md), and that a decoded box contains what was encoded.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>

#include "frontend/tracer/random_scene.h"
#include "grtx/frontend/accel/acceleration_structure.h"

namespace grtx::frontend {
namespace {

template <typename T>
T number_at(const NodeImage& image, std::uint64_t address) {
  T value;
  std::memcpy(&value, image.node(address), sizeof value);
  return value;
}

// Bits [7 i, 7 i + 7) of seven bytes, as one would write them down.
unsigned code_at(const std::uint8_t* bytes, unsigned i) {
  unsigned code = 0;
  for (unsigned bit = 0; bit < 7; ++bit) {
    const unsigned from = 7 * i + bit;
    code |= (bytes[from / 8] >> (from % 8) & 1u) << bit;
  }
  return code;
}

TEST(CompressedLayout, BytesLieWhereTheDocsSay) {
  NodeImage image(8, 64 * 12, 8, NodeLayout::compressed);
  ChildRecord children[8];
  for (unsigned i = 0; i < 8; ++i) {
    children[i].box.extend(glm::vec3(static_cast<float>(i)));
    children[i].box.extend(glm::vec3(static_cast<float>(i + 1)));
    children[i].kind = i == 1 || i == 6 ? NodeKind::instance : NodeKind::internal;
  }
  image.write_internal(64, 192, children, 8);
  EXPECT_EQ(number_at<glm::vec3>(image, 64), glm::vec3(0.0f));
  EXPECT_EQ(number_at<std::int32_t>(image, 76), 2);  // child base, in units from the node
  EXPECT_EQ(image.node(64)[16], 1u);                 // leaves are instances
  EXPECT_EQ(image.node(64)[17], 0xFFu);
  EXPECT_EQ(number_at<std::int8_t>(image, 82), 4);  // eight units in 128 steps of 2^(4 - 7)
  EXPECT_EQ(image.node(64)[21], 0b01000010u);
  for (unsigned i = 0; i < 8; ++i) {
    for (unsigned axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(code_at(image.node(64) + 22 + 14 * axis, i), 8 * i);            // lower
      EXPECT_EQ(code_at(image.node(64) + 22 + 14 * axis + 7, i), 8 * (i + 1));  // upper
    }
  }
  const DecodedInternal node = image.decode_internal(64);
  EXPECT_EQ(node.child_base, 192u);
  ASSERT_EQ(node.child_count, 8u);
  for (unsigned i = 0; i < 8; ++i) {
    EXPECT_EQ(node.kinds[i], children[i].kind);
    EXPECT_EQ(node.boxes[i].lower, children[i].box.lower);
    EXPECT_EQ(node.boxes[i].upper, children[i].box.upper);
  }

  const glm::vec3 to_object[3] = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
  const glm::vec3 to_world[3] = {{10, 11, 12}, {13, 14, 15}, {16, 17, 18}};
  image.write_instance(256, 77, 640, 704, to_object, to_world, {0.5f, 0.25f, 0.125f});
  EXPECT_EQ(number_at<glm::vec3>(image, 256 + 24), glm::vec3(7, 8, 9));
  EXPECT_EQ(number_at<glm::vec3>(image, 256 + 36), glm::vec3(0.5f, 0.25f, 0.125f));
  EXPECT_EQ(number_at<std::uint64_t>(image, 256 + 48), 704u);  // BLAS root
  EXPECT_EQ(image.instance_index(256), 77u);
  EXPECT_EQ(image.leaf_index(4), 77u);
}

TEST(CompressedLayout, DecodedBoxesContainTheirChildren) {
  std::mt19937 engine(9);
  const auto uniform = [&](float low, float high) {
    return low + (high - low) * (static_cast<float>(engine() >> 8) / 16777216.0f);
  };
  for (int trial = 0; trial < 2000; ++trial) {
    const unsigned bits = 2 + static_cast<unsigned>(engine() % 7), count = 1 + static_cast<unsigned>(engine() % 8);
    NodeImage image(8, 128, bits, NodeLayout::compressed);
    ChildRecord children[8];
    for (unsigned i = 0; i < count; ++i) {
      const float scale = std::ldexp(1.0f, static_cast<int>(engine() % 20) - 10);
      const glm::vec3 corner{uniform(-5, 5), uniform(-5, 5), uniform(-5, 5)};
      children[i].box.extend(corner);
      children[i].box.extend(corner + scale * glm::vec3{uniform(0, 1), uniform(0, 1), uniform(0, 1)});
      children[i].kind = engine() % 2 == 0 ? NodeKind::triangle : NodeKind::internal;
    }
    image.write_internal(0, 64, children, count);
    const DecodedInternal node = image.decode_internal(0);
    ASSERT_EQ(node.child_count, count);
    for (unsigned i = 0; i < count; ++i) {
      ASSERT_EQ(node.kinds[i], children[i].kind);
      for (int axis = 0; axis < 3; ++axis) {
        ASSERT_LE(node.boxes[i].lower[axis], children[i].box.lower[axis]);
        ASSERT_GE(node.boxes[i].upper[axis], children[i].box.upper[axis]);
      }
    }
  }
}

TEST(CompressedLayout, EveryNodeIsOneUnit) {
  const Scene scene = test::random_scene(6);
  const PreparedGaussians gaussians(scene, true);
  for (const auto kind : {AccelKind::tri20, AccelKind::ellipsoid, AccelKind::tlas_tri20, AccelKind::tlas_sphere}) {
    const AccelerationStructure accel(gaussians, {kind, 8, false, 8, NodeLayout::compressed});
    const auto& nodes = accel.counts();
    const std::uint64_t headers = is_two_level(kind) ? 2 : 1;
    EXPECT_EQ(accel.image().size(),
              64 * (headers + nodes.internal + nodes.instance + nodes.triangle + nodes.procedural + nodes.blas_nodes))
        << accel_name(kind);
  }
}

}  // namespace
}  // namespace grtx::frontend
