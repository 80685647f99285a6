// SPDX-License-Identifier: Apache-2.0
// Packing by several threads against the plain way, one node after the other; and the boxes that trees are built of.
#include "grtx/frontend/accel/tree_packer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <cstring>
#include <random>
#include <vector>

#include "frontend/tracer/random_scene.h"
#include "grtx/frontend/gaussian/prepared_gaussians.h"

namespace grtx::frontend {
namespace {

struct Leaf {
  void operator()(NodeImage& image, std::uint64_t address, std::uint32_t index) const {
    image.write_triangle(address, index, glm::vec3(static_cast<float>(index)), {1, 2, 3}, {4, 5, 6});
  }
};

// A node's children lie together, then each child's subtree follows.
std::uint64_t pack_plainly(NodeImage& image, const TreeNode& node, std::uint64_t address, std::uint64_t next) {
  ChildRecord records[traces::kMaxWidth];
  std::uint64_t addresses[traces::kMaxWidth] = {};
  const std::uint64_t base = next;
  for (unsigned i = 0; i < node.child_count; ++i) {
    records[i] = {node.children[i].box, node.children[i].leaf() ? NodeKind::triangle : NodeKind::internal};
    addresses[i] = next;
    next += traces::node_bytes(records[i].kind, image.width());
  }
  image.write_internal(address, base, records, node.child_count);
  for (unsigned i = 0; i < node.child_count; ++i) {
    const TreeChild& child = node.children[i];
    if (child.leaf()) {
      Leaf()(image, addresses[i], child.primitive());
    } else {
      next = pack_plainly(image, child.node(), addresses[i], next);
    }
  }
  return next;
}

std::vector<Box> random_boxes(std::size_t count, unsigned seed) {
  std::mt19937 engine(seed);
  const auto uniform = [&] { return static_cast<float>(engine() >> 8) / 16777216.0f; };
  std::vector<Box> boxes(count);
  for (Box& box : boxes) {
    const glm::vec3 at{uniform() * 100 - 50, uniform() * uniform() * 10, engine() % 4 == 0 ? 0.0f : uniform()};
    box.extend(at);
    box.extend(at + glm::vec3{uniform(), uniform(), uniform()} * (engine() % 8 == 0 ? 5.0f : 0.1f));
  }
  return boxes;
}

TEST(TreePacker, PacksAsThePlainWayForAllWidthsBitsSizesAndThreads) {
  for (unsigned width = 2; width <= traces::kMaxWidth; ++width) {
    for (const std::size_t count : {0u, 1u, 2u, 3u, 9u, 500u, 30000u}) {
      const unsigned bits = count < 100 ? 2 + static_cast<unsigned>(count + width) % 7 : 10 - width;
      const std::vector<Box> boxes = random_boxes(count, width);
      std::vector<std::uint8_t> expected;
      for (const int threads : {1, 4}) {
        const tbb::global_control control(tbb::global_control::max_allowed_parallelism,
                                          static_cast<std::size_t>(threads));
        const Tree tree = build_tree(
            count, [&](std::size_t i) { return boxes[i]; }, width);
        ASSERT_EQ(tree.leaves, count);
        const std::uint64_t bytes = packed_bytes(tree, NodeKind::triangle, {traces::NodeLayout::vulkan_sim, width});
        NodeImage plain(width, bytes, bits);
        plain.write_header(0, traces::kHeaderBytes, tree.bounds);
        const std::uint64_t below = traces::kHeaderBytes + traces::internal_bytes(width);
        ASSERT_EQ(pack_plainly(plain, *tree.root, traces::kHeaderBytes, below), bytes);
        for (const bool consume : {false, true}) {  // in this order: a consumed tree is gone
          NodeImage image(width, bytes, bits);
          EXPECT_EQ(TreePacker(image, tree, NodeKind::triangle, Leaf(), consume).pack(bytes), traces::kHeaderBytes);
          EXPECT_EQ(std::memcmp(image.data(), plain.data(), bytes), 0)
              << "width " << width << ", " << count << " primitives, threads " << threads << ", consume " << consume;
          EXPECT_TRUE(std::equal(image.leaf_indices(), image.leaf_indices() + bytes / 64, plain.leaf_indices()));
        }
        const std::vector<std::uint8_t> packed(plain.data(), plain.data() + bytes);
        if (threads == 1) expected = packed;
        EXPECT_TRUE(packed == expected) << "threads change bytes: width " << width << ", " << count << " primitives";
      }
    }
  }
}

TEST(TreePacker, PacksOverWhatLiesThere) {
  const std::vector<Box> boxes = random_boxes(40, 1);
  const Tree tree = build_tree(
      boxes.size(), [&](std::size_t i) { return boxes[i]; }, 8);
  const std::uint64_t bytes = packed_bytes(tree, NodeKind::triangle, {traces::NodeLayout::vulkan_sim, 8});
  NodeImage once(8, bytes), twice(8, bytes);
  TreePacker(once, tree, NodeKind::triangle, Leaf()).pack(bytes);
  for (std::uint64_t at = 0; at < bytes; at += 64) twice.write_procedural(at, 0xFFFFFFFFu);
  TreePacker(twice, tree, NodeKind::triangle, Leaf()).pack_at(0);
  EXPECT_EQ(std::memcmp(once.data(), twice.data(), bytes), 0);
}

/// Nodes above the subtrees, written first, touched every large page of an image of 2 GB while all of the tree was
/// still there.
TEST(TreePacker, WritesWhatLiesAllOverTheImageLast) {
  const std::vector<Box> boxes = random_boxes(30000, 2);
  const Tree tree = build_tree(
      boxes.size(), [&](std::size_t i) { return boxes[i]; }, 6);
  const std::uint64_t bytes = packed_bytes(tree, NodeKind::triangle, {traces::NodeLayout::vulkan_sim, 6});
  NodeImage image(6, bytes);
  const std::uint8_t* const root = image.node(traces::kHeaderBytes);
  std::atomic<unsigned> before = 0, after = 0;  // leaves, by whether the root is written
  const auto leaf = [&](NodeImage& into, std::uint64_t address, std::uint32_t index) {
    ++(root[21] == 0 ? before : after);  // a node's mask of what it is visible to, 0xFF
    Leaf()(into, address, index);
  };
  EXPECT_EQ(TreePacker(image, tree, NodeKind::triangle, leaf, true).pack(bytes), traces::kHeaderBytes);
  EXPECT_EQ(root[21], 0xFF);
  EXPECT_EQ(before + after, 30000U);
  EXPECT_GT(before, 29900U);
}

TEST(TreeMemory, AChunkStaysUntilItsLastNodeIsReleased) {
  constexpr std::size_t kNode = 208, kNodes = 40000;  // some 8 MB, several chunks
  TreeMemory memory(kNode * kNodes);
  std::vector<std::uint8_t*> nodes(kNodes);
  tbb::parallel_for(std::size_t{0}, kNodes, [&](std::size_t i) {
    nodes[i] = static_cast<std::uint8_t*>(memory.allocate(kNode));
    std::memset(nodes[i], static_cast<int>(1 + i % 255), kNode);
  });
  for (std::size_t i = 0; i < kNodes; ++i) {
    ASSERT_EQ(nodes[i][0], 1 + i % 255) << "node " << i;
    ASSERT_EQ(nodes[i][kNode - 1], 1 + i % 255) << "node " << i;
    memory.release(nodes[i]);
  }
#if defined(__linux__)
  for (const std::uint8_t* node : nodes) ASSERT_EQ(*node, 0);  // fresh pages
#endif
}

TEST(PreparedGaussians, BoxesOfManyAreTheBoxesOfEach) {
  const Scene scene = test::random_scene(5, {300, 100.0, -2.5, 2.0, 0.02, 0.95, 0});
  const PreparedGaussians gaussians(scene, true);
  for (const ProxyKind kind : {ProxyKind::icosahedron20, ProxyKind::icosphere80, ProxyKind::sphere}) {
    const Proxy proxy(kind);
    const std::size_t faces = proxy.is_sphere() ? 1 : proxy.faces();
    std::vector<PrimitiveBox> boxes(300 * faces);
    gaussians.write_face_boxes(0, 300, proxy, boxes.data());
    for (std::uint32_t i = 0; i < boxes.size(); ++i) {
      const Box one =
          gaussians.face_box(i / static_cast<std::uint32_t>(faces), proxy, i % static_cast<unsigned>(faces));
      const Box of_many = boxes[i].box();
      ASSERT_EQ(std::memcmp(&one, &of_many, sizeof one), 0) << "primitive " << i;
    }
    for (const bool corners : {false, true}) {
      gaussians.write_instance_boxes(100, 300, proxy, corners, boxes.data());
      for (std::uint32_t i = 0; i < 200; ++i) {
        const Box one = gaussians.instance_box(100 + i, proxy, corners), of_many = boxes[i].box();
        ASSERT_EQ(std::memcmp(&one, &of_many, sizeof one), 0) << "Gaussian " << 100 + i;
      }
    }
  }
}

}  // namespace
}  // namespace grtx::frontend
