// SPDX-License-Identifier: Apache-2.0
// Layout compact, byte for byte (docs/model/node-image.md), and that its structures hold what those of vulkan_sim hold.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <set>

#include "frontend/tracer/random_scene.h"
#include "grtx/frontend/accel/acceleration_structure.h"

namespace grtx::frontend {
namespace {

template <typename T>
T at(const NodeImage& image, std::uint64_t address) {
  T value;
  std::memcpy(&value, image.node(address), sizeof value);
  return value;
}

bool same(const glm::vec3& a, const glm::vec3& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

TEST(FacePatches, HoldEveryFaceOnceWithItsWinding) {
  for (const ProxyKind kind : {ProxyKind::icosahedron20, ProxyKind::icosphere80}) {
    const Proxy proxy(kind);
    const FacePatches patches(proxy);
    ASSERT_EQ(patches.count(), proxy.faces() / 4);
    std::set<unsigned> seen;
    for (unsigned p = 0; p < patches.count(); ++p) {
      const FacePatch& patch = patches.patches()[p];
      EXPECT_EQ(patch.code & 7u, 4u);
      EXPECT_EQ(patch.code >> 3 & 31u, p);
      EXPECT_EQ(std::set<unsigned>(patch.vertices.begin(), patch.vertices.end()).size(), 6u);
      for (unsigned i = 0; i < 4; ++i) {
        const unsigned face = patch.faces[i];
        EXPECT_TRUE(seen.insert(face).second);
        EXPECT_EQ(patches.patch_of()[face], p);
        std::array<std::uint16_t, 3> corners{patch.vertices[0], patch.vertices[1], patch.vertices[2]};
        if (i > 0) {
          const unsigned edge = patch.code >> (8 + 6 * (i - 1));
          corners = {patch.vertices[edge & 7u], patch.vertices[edge >> 3 & 7u], patch.vertices[i + 2]};
        }
        const auto& triangle = proxy.triangles()[face];
        std::rotate(corners.begin(), std::find(corners.begin(), corners.end(), triangle[0]), corners.end());
        EXPECT_EQ(corners, triangle);
        for (int axis = 0; axis < 3; ++axis) {
          EXPECT_LE(patch.object_box.lower[axis], proxy.face_box(face).lower[axis]);
          EXPECT_GE(patch.object_box.upper[axis], proxy.face_box(face).upper[axis]);
        }
      }
    }
    EXPECT_EQ(seen.size(), proxy.faces());
  }
}

TEST(CompactLayout, BytesLieWhereTheDocsSay) {
  NodeImage image(8, 80 * 5, 8, NodeLayout::compact);
  EXPECT_EQ(image.size(), 400u);
  ChildRecord children[8];
  for (unsigned i = 0; i < 8; ++i) {
    children[i].box.extend(glm::vec3(static_cast<float>(i)));
    children[i].box.extend(glm::vec3(static_cast<float>(i + 1)));
    children[i].kind = i == 1 ? NodeKind::instance : NodeKind::triangle;
  }
  image.write_internal(80, 240, children, 8);
  EXPECT_EQ(at<glm::vec3>(image, 80), glm::vec3(0.0f));
  EXPECT_EQ(at<std::int32_t>(image, 92), 2);    // child base, in units from the node
  EXPECT_EQ(image.node(80)[22], 1u | 4u << 2);  // one unit, triangle
  EXPECT_EQ(image.node(80)[23], 2u | 1u << 2);  // two units, instance
  const int exponent = at<std::int8_t>(image, 98);
  EXPECT_EQ(exponent, 4);  // eight units in 256 steps of 2^(4 - 8)
  for (unsigned i = 0; i < 8; ++i) {
    for (unsigned axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(image.node(80)[32 + 16 * axis + i], 16 * i);            // lower
      EXPECT_EQ(image.node(80)[32 + 16 * axis + 8 + i], 16 * (i + 1));  // upper
    }
  }
  image.write_patch(
      160, {7, 0x12345u, {glm::vec3(1), glm::vec3(2), glm::vec3(3), glm::vec3(4), glm::vec3(5), glm::vec3(6)}}, 35);
  EXPECT_EQ(at<glm::vec3>(image, 160 + 60), glm::vec3(6.0f));
  EXPECT_EQ(image.read_u32(160 + 72), 7u);
  EXPECT_EQ(image.read_u32(160 + 76), 0x12345u);
  EXPECT_EQ(image.leaf_index(2), 35u);

  const glm::vec3 to_object[3] = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
  const glm::vec3 to_world[3] = {{10, 11, 12}, {13, 14, 15}, {16, 17, 18}};
  image.write_instance(240, 77, 800, 880, to_object, to_world, {0.5f, 0.25f, 0.125f});
  EXPECT_EQ(at<glm::vec3>(image, 240 + 24), glm::vec3(7, 8, 9));
  EXPECT_EQ(at<glm::vec3>(image, 240 + 36), glm::vec3(0.5f, 0.25f, 0.125f));
  EXPECT_EQ(at<std::uint64_t>(image, 240 + 48), 880u);  // BLAS root
  EXPECT_EQ(at<std::uint64_t>(image, 240 + 56), 800u);  // BLAS header
  EXPECT_EQ(image.instance_index(240), 77u);
  EXPECT_EQ(at<glm::vec3>(image, 240 + 80), glm::vec3(10, 11, 12));
  EXPECT_EQ(image.leaf_index(3), 77u);

  Box box;
  box.extend(glm::vec3(-1.0f));
  box.extend(glm::vec3(2.0f));
  image.write_procedural(160, 9, box, to_object, {3, 2, 1});
  EXPECT_EQ(at<glm::vec3>(image, 160 + 12), glm::vec3(2.0f));
  EXPECT_EQ(at<glm::vec3>(image, 160 + 24), glm::vec3(1, 2, 3));
  EXPECT_EQ(at<glm::vec3>(image, 160 + 60), glm::vec3(3, 2, 1));
  EXPECT_EQ(image.procedural_primitive(160), 9u);
}

// Walks from a root; each node's decoded box must contain what lies below it. Counts leaves, and compares triangles
// with those of layout vulkan_sim.
struct Walk {
  const AccelerationStructure& accel;
  const PreparedGaussians& gaussians;
  std::vector<unsigned> seen{};
  bool blas = false;

  Box face_box(std::uint32_t g, unsigned face) const {
    return blas ? accel.proxy().face_box(face) : gaussians.face_box(g, accel.proxy(), face);
  }
  glm::vec3 vertex(std::uint32_t g, unsigned v) const {
    const glm::vec3& unit = accel.proxy().vertices()[v];
    return blas ? unit : gaussians.to_world(g, unit);
  }
  Box visit(std::uint64_t address, NodeKind kind) {
    const NodeImage& image = accel.image();
    Box box;
    if (kind == NodeKind::internal) {
      const DecodedInternal node = image.decode_internal(address);
      std::uint64_t child = node.child_base;
      for (unsigned i = 0; i < node.child_count; ++i) {
        const Box below = visit(child, node.kinds[i]);
        for (int axis = 0; axis < 3; ++axis) {
          EXPECT_LE(node.boxes[i].lower[axis], below.lower[axis]);
          EXPECT_GE(node.boxes[i].upper[axis], below.upper[axis]);
        }
        box.extend(below);
        child += image.sizes().bytes(node.kinds[i]);
      }
      return box;
    }
    if (kind == NodeKind::instance) {
      ++seen.at(image.instance_index(address));
      return gaussians.instance_box(image.instance_index(address), accel.proxy(), accel.options().corner_bounds);
    }
    if (kind == NodeKind::procedural) {
      ++seen.at(image.procedural_primitive(address));
      return face_box(image.procedural_primitive(address), 0);
    }
    const std::uint32_t g = image.patch_gaussian(address);
    const auto units = static_cast<std::uint32_t>(address / image.sizes().unit());
    const unsigned count = accel.patches().count();
    const std::uint32_t leaf = image.leaf_index(units);
    EXPECT_EQ(leaf / count, g);
    ++seen.at(leaf);
    for (unsigned i = 0; i < image.triangle_count(units); ++i) {
      const unsigned face = accel.patches().patches()[leaf % count].faces[i];
      box.extend(face_box(g, face));
      // The same three vertices, to the bit, perhaps beginning with another.
      auto stored = image.triangle(units, i);
      const auto& corners = accel.proxy().triangles()[face];
      const auto first = std::find_if(stored.begin(), stored.end(),
                                      [&](const glm::vec3& v) { return same(v, vertex(g, corners[0])); });
      EXPECT_NE(first, stored.end());
      if (first == stored.end()) continue;
      std::rotate(stored.begin(), first, stored.end());
      EXPECT_TRUE(same(stored[1], vertex(g, corners[1])) && same(stored[2], vertex(g, corners[2])));
    }
    return box;
  }
};

TEST(CompactLayout, EveryLeafIsReachedOnceInsideItsBoxes) {
  const Scene scene = test::random_scene(2, {64, 1.0, -2.5, 1.0, 0.02, 0.95, 0});
  const PreparedGaussians gaussians(scene, true);
  for (const std::string& name : names_of<AccelKind>()) {
    for (const unsigned width : {2u, 6u, 8u}) {
      const AccelerationStructure accel(gaussians, {accel_from_name(name), width, false, 8, NodeLayout::compact});
      const std::size_t leaves = accel.two_level() || accel.proxy().is_sphere() ? 64 : 64u * accel.patches().count();
      Walk walk{accel, gaussians, std::vector<unsigned>(leaves, 0)};
      walk.visit(accel.root(), NodeKind::internal);
      EXPECT_EQ(walk.seen, std::vector<unsigned>(leaves, 1)) << name << " width " << width;
      if (!accel.two_level()) continue;
      Walk blas{accel, gaussians, std::vector<unsigned>(accel.patches().count(), 0), true};
      blas.visit(accel.blas_root(), NodeKind::internal);
      EXPECT_EQ(blas.seen, std::vector<unsigned>(accel.patches().count(), 1)) << name << " width " << width;
    }
  }
}

TEST(CompactLayout, TakesAThirdOfTheBytesOfAMonolithicStructure) {
  const Scene scene = test::random_scene(3, {2000, 1.0, -4.0, 1.0, 0.02, 0.95, 0});
  const PreparedGaussians gaussians(scene, true);
  const auto bytes = [&](AccelKind kind, unsigned width, NodeLayout layout) {
    return static_cast<double>(AccelerationStructure(gaussians, {kind, width, false, 8, layout}).image().size()) /
           2000.0;
  };
  // Five leaves of 80 B and 80 / (fan-out - 1) for each; shipping drivers take 455 B, vulkan_sim 1,714 B.
  EXPECT_GT(bytes(AccelKind::tri20, 8, NodeLayout::compact), 400.0 * (1.0 + 1.0 / 7.0));
  EXPECT_LT(bytes(AccelKind::tri20, 8, NodeLayout::compact), bytes(AccelKind::tri20, 6, NodeLayout::vulkan_sim) / 3.0);
  // An instance leaf takes two units; shipping drivers take 190 B.
  EXPECT_GT(bytes(AccelKind::tlas_tri20, 8, NodeLayout::compact), 160.0 * (1.0 + 0.5 / 7.0));
  EXPECT_LT(bytes(AccelKind::tlas_tri20, 8, NodeLayout::compact), 200.0);
}

TEST(CompactLayout, EmptySceneAndOneGaussian) {
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}}) {
    const Scene scene = test::random_scene(2, {count, 1.0, -2.5, 1.0, 0.5, 0.95, 0});
    const PreparedGaussians gaussians(scene, true);
    for (const std::string& name : names_of<AccelKind>()) {
      const AccelerationStructure accel(gaussians, {accel_from_name(name), 8, false, 8, NodeLayout::compact});
      EXPECT_EQ(accel.image().decode_internal(accel.root()).child_count > 0, count > 0) << name;
    }
  }
}

}  // namespace
}  // namespace grtx::frontend
