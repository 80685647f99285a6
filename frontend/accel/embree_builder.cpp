// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/accel/embree_builder.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cstddef>
#include <new>
#include <stdexcept>
#include <string>

namespace grtx::frontend {
namespace {

static_assert(sizeof(RTCBuildPrimitive) == sizeof(PrimitiveBox) &&
              offsetof(RTCBuildPrimitive, upper_x) == offsetof(PrimitiveBox, upper) &&
              offsetof(RTCBuildPrimitive, primID) == offsetof(PrimitiveBox, primitive));

constexpr std::size_t node_size(unsigned child_count) {
  return offsetof(TreeNode, children) + child_count * sizeof(TreeChild);
}
static_assert(node_size(traces::kMaxWidth) <= TreeMemory::kLargestNode);

// A tree over n primitives of this many bytes at most: each of its n - 1 nodes has two children.
std::size_t most_bytes(std::size_t primitives) { return (primitives + 1) * node_size(2); }

// A leaf is a tagged primitive index and takes no memory of its own; nodes are 16-byte aligned.
std::uintptr_t leaf_link(std::uint32_t primitive) { return (static_cast<std::uintptr_t>(primitive) << 1) | 1u; }

TreeNode* new_node(TreeMemory& memory, unsigned child_count) {
  auto* node = static_cast<TreeNode*>(memory.allocate(node_size(child_count)));
  node->child_count = static_cast<std::uint8_t>(child_count);
  return node;
}

/// Embree hands this to the functions below.
struct Build {
  TreeMemory& memory;
  const IsWide& is_wide;
};

void* create_node(RTCThreadLocalAllocator, unsigned child_count, void* build) {
  return new_node(static_cast<Build*>(build)->memory, child_count);
}

void set_bounds(void* node, const RTCBounds** bounds, unsigned count, void*) {
  for (unsigned i = 0; i < count; ++i) {
    Box& box = static_cast<TreeNode*>(node)->children[i].box;
    const RTCBounds& b = *bounds[i];
    box.lower = {b.lower_x, b.lower_y, b.lower_z};
    box.upper = {b.upper_x, b.upper_y, b.upper_z};
  }
}

// Called once the children are complete, so that the node's subtree can be counted.
void set_children(void* pointer, void** children, unsigned count, void* build) {
  auto* const node = static_cast<TreeNode*>(pointer);
  const IsWide& is_wide = static_cast<Build*>(build)->is_wide;
  std::uint32_t internals = 1, leaves = 0, wide = 0;
  std::uint8_t below = count > 0 ? 1 : 0;
  for (unsigned i = 0; i < count; ++i) {
    TreeChild& child = node->children[i];
    child.link = reinterpret_cast<std::uintptr_t>(children[i]);
    if (child.leaf()) {
      ++leaves;
      wide += is_wide && is_wide(child.primitive()) ? 1 : 0;
      continue;
    }
    internals += child.node().internals;
    wide += child.node().wide;
    leaves += child.node().leaves;
    below = std::max(below, child.node().levels);
  }
  node->internals = internals;
  node->leaves = leaves;
  node->wide = wide;
  node->levels = static_cast<std::uint8_t>(below + 1);
}

void* create_leaf(RTCThreadLocalAllocator, const RTCBuildPrimitive* primitives, [[maybe_unused]] std::size_t count,
                  void*) {
  assert(count == 1);
  return reinterpret_cast<void*>(leaf_link(primitives[0].primID));
}

// Writes all boxes; returns the box around them. Parts are joined in order, so that the result does not depend on the
// threads: of zeros of either sign the first one stays.
Box write_all(std::size_t count, std::size_t group, const BoxWriter& write_boxes, PrimitiveBox* boxes) {
  using Range = tbb::blocked_range<std::size_t>;
  constexpr std::size_t kAtOnce = 256;  // boxes that are still in the first cache when read again
  const std::size_t grain = std::max<std::size_t>(1, 16 * kAtOnce / group);
  const auto write = [&](const Range& groups, Box bounds) {
    for (std::size_t i = groups.begin() * group; i < groups.end() * group;) {
      const std::size_t end = std::min(groups.end() * group, i + std::max<std::size_t>(1, kAtOnce / group) * group);
      write_boxes(i, end, boxes + i);
      for (; i < end; ++i) {
        boxes[i].geometry = 0;
        boxes[i].primitive = static_cast<std::uint32_t>(i);
        bounds.extend(boxes[i].box());
      }
    }
    return bounds;
  };
  const auto join = [](Box left, const Box& right) {
    left.extend(right);
    return left;
  };
  return tbb::parallel_reduce(Range(0, count / group, grain), Box(), write, join);
}

struct Device {
  RTCDevice device = rtcNewDevice(nullptr);
  RTCBVH bvh = device != nullptr ? rtcNewBVH(device) : nullptr;
  Device() = default;
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  ~Device() {
    if (bvh != nullptr) rtcReleaseBVH(bvh);
    if (device != nullptr) rtcReleaseDevice(device);
  }
};

void* run_embree(PrimitiveBox* boxes, std::size_t count, unsigned width, Build& build, double& seconds) {
  const Device embree;
  if (embree.bvh == nullptr) {
    if (rtcGetDeviceError(embree.device) == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
    throw std::runtime_error("Embree device cannot be created");
  }
  RTCBuildArguments arguments = rtcDefaultBuildArguments();
  arguments.byteSize = sizeof arguments;
  arguments.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
  arguments.maxBranchingFactor = width;
  arguments.minLeafSize = 1;
  arguments.maxLeafSize = 1;
  arguments.bvh = embree.bvh;
  arguments.primitives = reinterpret_cast<RTCBuildPrimitive*>(boxes);
  arguments.primitiveCount = count;
  arguments.primitiveArrayCapacity = count;
  arguments.createNode = create_node;
  arguments.setNodeChildren = set_children;
  arguments.setNodeBounds = set_bounds;
  arguments.createLeaf = create_leaf;
  arguments.userPtr = &build;
  const auto start = std::chrono::steady_clock::now();
  void* const root = rtcBuildBVH(&arguments);
  seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (root == nullptr) {
    const RTCError error = rtcGetDeviceError(embree.device);
    if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
    throw std::runtime_error("rtcBuildBVH failed with Embree error " + std::to_string(error));
  }
  return root;
}

}  // namespace

Tree build_tree(std::size_t count, std::size_t group, const BoxWriter& write_boxes, unsigned width,
                const IsWide& is_wide) {
  assert(count % group == 0);
  Tree tree;
  tree.memory = std::make_unique<TreeMemory>(most_bytes(count));
  Build build{*tree.memory, is_wide};
  void* root = nullptr;
  if (count > 0) {
    ZeroedPages<PrimitiveBox> boxes(count);
    tree.bounds = write_all(count, group, write_boxes, boxes.data());
    root = run_embree(boxes.data(), count, width, build, tree.build_seconds);
  } else {
    tree.bounds.lower = tree.bounds.upper = glm::vec3(0.0f);
  }
  TreeChild top{tree.bounds, reinterpret_cast<std::uintptr_t>(root)};
  if (count == 0 || top.leaf()) {
    TreeNode* const node = new_node(*tree.memory, count == 0 ? 0 : 1);
    if (count > 0) node->children[0].box = tree.bounds;
    set_children(node, &root, node->child_count, &build);
    top.link = reinterpret_cast<std::uintptr_t>(node);
  }
  tree.root = &top.node();
  tree.internals = tree.root->internals;
  tree.leaves = tree.root->leaves;
  tree.wide = tree.root->wide;
  tree.height = tree.root->levels;
  // Embree leaves out primitives whose boxes are not finite; loading admits none, and a loss must not be silent.
  assert(tree.leaves == count);
  return tree;
}

}  // namespace grtx::frontend
