// SPDX-License-Identifier: Apache-2.0
// The node image: decoded boxes contain what was encoded; headers, leaves and instances lie where the layout says.
#include "grtx/frontend/accel/node_image.h"

#include <gtest/gtest.h>

#include <random>

#include "frontend/tracer/random_scene.h"
#include "grtx/frontend/accel/acceleration_structure.h"

namespace grtx::frontend {
namespace {

TEST(NodeImage, DecodedBoxesContainTheEncodedOnes) {
  std::mt19937 engine(7);
  const auto uniform = [&](float low, float high) {
    return low + (high - low) * (static_cast<float>(engine() >> 8) / 16777216.0f);
  };
  for (int trial = 0; trial < 2000; ++trial) {
    const auto count = static_cast<unsigned>(1 + engine() % 6);
    const float centre = std::pow(10.0f, uniform(-6.0f, 6.0f)) * (trial % 2 == 0 ? 1.0f : -1.0f);
    const float extent = std::pow(10.0f, uniform(-9.0f, 6.0f));
    ChildRecord children[6];
    for (unsigned i = 0; i < count; ++i) {
      Box box;
      box.extend(glm::vec3(centre) + glm::vec3{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)} * extent);
      if (trial % 5 != 0) box.extend(box.lower + glm::vec3{uniform(0, 1), uniform(0, 1), uniform(0, 1)} * extent);
      children[i] = {box, i % 2 == 0 ? NodeKind::internal : NodeKind::triangle};
    }
    const unsigned box_bits = 2 + static_cast<unsigned>(trial) % 7;
    NodeImage image(6, 128, box_bits);
    image.write_internal(0, 64, children, count);
    for (unsigned i = 0; i < 6 * count; ++i) {
      const std::uint8_t code = image.node(0)[28 + i / count * 6 + i % count];
      EXPECT_EQ(code % (1u << (8 - box_bits)), 0u);  // the unused bits are zero
    }
    const DecodedInternal node = image.decode_internal(0);
    ASSERT_EQ(node.child_count, count);
    EXPECT_EQ(node.child_base, 64u);
    for (unsigned i = 0; i < count; ++i) {
      EXPECT_EQ(node.kinds[i], children[i].kind);
      for (int axis = 0; axis < 3; ++axis) {
        ASSERT_LE(node.boxes[i].lower[axis], children[i].box.lower[axis]);
        ASSERT_GE(node.boxes[i].upper[axis], children[i].box.upper[axis]);
      }
    }
  }
}

TEST(NodeImage, InstanceLeafHoldsTheTransformWhereXePutsIt) {
  NodeImage image(6, 128);
  const glm::vec3 world_to_object[3] = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
  const glm::vec3 object_to_world[3] = {{10, 11, 12}, {13, 14, 15}, {16, 17, 18}};
  image.write_instance(0, 77, 640, 704, world_to_object, object_to_world, {0.5f, 0.25f, 0.125f});
  float value = 0.0f;
  std::memcpy(&value, image.node(16 + 4 * 5), 4);
  EXPECT_EQ(value, 6.0f);  // row 1, column 2 of the world-to-object matrix
  std::memcpy(&value, image.node(52), 4);
  EXPECT_EQ(value, 0.5f);  // object-to-world translation sits in the first half
  EXPECT_EQ(image.instance_index(0), 77u);
  EXPECT_EQ(image.read_u32(8), 704u);
  EXPECT_EQ(image.read_u32(64), 640u);
}

// Walks the image from the root; each node's decoded box must contain the boxes of all primitives below it.
struct Walk {
  const AccelerationStructure& accel;
  const PreparedGaussians& gaussians;
  std::vector<unsigned> seen;

  Box visit(std::uint64_t address, NodeKind kind) {
    Box box;
    if (kind == NodeKind::internal) {
      const DecodedInternal node = accel.image().decode_internal(address);
      std::uint64_t child = node.child_base;
      for (unsigned i = 0; i < node.child_count; ++i) {
        const Box below = visit(child, node.kinds[i]);
        for (int axis = 0; axis < 3; ++axis) {
          EXPECT_LE(node.boxes[i].lower[axis], below.lower[axis]);
          EXPECT_GE(node.boxes[i].upper[axis], below.upper[axis]);
        }
        box.extend(below);
        child += traces::node_bytes(node.kinds[i], accel.options().width);
      }
      return box;
    }
    const Proxy& proxy = accel.proxy();
    if (kind == NodeKind::instance) {
      const std::uint32_t g = accel.image().instance_index(address);
      ++seen.at(g);
      return gaussians.instance_box(g, proxy, accel.options().corner_bounds);
    }
    const std::uint32_t primitive =
        kind == NodeKind::triangle ? accel.image().primitive(address) : accel.image().procedural_primitive(address);
    ++seen.at(primitive);
    const std::uint32_t faces = proxy.is_sphere() ? 1 : proxy.faces();
    return gaussians.face_box(primitive / faces, proxy, primitive % faces);
  }
};

TEST(NodeImage, EveryPrimitiveIsReachedOnceInsideItsBoxes) {
  const Scene scene = test::random_scene(2, {64, 1.0, -2.5, 1.0, 0.02, 0.95, 0});
  const PreparedGaussians gaussians(scene, true);
  for (const std::string& name : names_of<AccelKind>()) {
    for (const unsigned width : {2u, 6u, 8u}) {
      const AccelerationStructure accel(gaussians, {accel_from_name(name), width, false});
      const std::size_t leaves = accel.two_level() || accel.proxy().is_sphere() ? 64 : 64u * accel.proxy().faces();
      Walk walk{accel, gaussians, std::vector<unsigned>(leaves, 0)};
      walk.visit(accel.root(), NodeKind::internal);
      EXPECT_EQ(walk.seen, std::vector<unsigned>(leaves, 1)) << name << " width " << width;
    }
  }
}

TEST(NodeImage, InstanceBoxesContainTheirFaces) {
  const Scene scene = test::random_scene(4, {200, 100.0, -2.5, 2.0, 0.02, 0.95, 0});
  const PreparedGaussians gaussians(scene, true);
  for (const ProxyKind kind : {ProxyKind::icosahedron20, ProxyKind::icosphere80}) {
    const Proxy proxy(kind);
    for (const bool corners : {false, true}) {
      for (std::uint32_t g = 0; g < scene.size(); ++g) {
        const Box outer = gaussians.instance_box(g, proxy, corners);
        for (unsigned face = 0; face < proxy.faces(); ++face) {
          const Box inner = gaussians.face_box(g, proxy, face);
          for (int axis = 0; axis < 3; ++axis) {
            ASSERT_LE(outer.lower[axis], inner.lower[axis]);
            ASSERT_GE(outer.upper[axis], inner.upper[axis]);
          }
        }
      }
    }
  }
}

TEST(NodeImage, EmptySceneAndOneGaussian) {
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}}) {
    const Scene scene = test::random_scene(2, {count, 1.0, -2.5, 1.0, 0.5, 0.95, 0});
    const PreparedGaussians gaussians(scene, true);
    for (const std::string& name : names_of<AccelKind>()) {
      const AccelerationStructure accel(gaussians, {accel_from_name(name), 6, false});
      EXPECT_EQ(accel.image().decode_internal(accel.root()).child_count > 0, count > 0) << name;
    }
  }
}

}  // namespace
}  // namespace grtx::frontend
