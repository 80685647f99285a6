#include "frontend/embree_builder.h"

#include <embree3/rtcore.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cassert>
#include <chrono>
#include <stdexcept>
#include <tuple>

namespace grtx::frontend {
namespace {

// What Embree's callbacks build. A leaf is a tagged primitive index and takes no memory of its own.
struct BuildNode {
  std::uint32_t child_count;
  std::uint32_t pad;
  struct Child {  // smaller than with an RTCBounds, which is padded: these nodes make the peak of a build's memory
    float lower[3];
    float upper[3];
    void* node;
  } children[8];
};

// Leaves are tagged in bit 0; BuildNodes are 16-byte aligned.
void* leaf_pointer(std::uint32_t primitive) {
  return reinterpret_cast<void*>((static_cast<std::uintptr_t>(primitive) << 1) | 1u);
}
bool is_leaf(const void* node) { return (reinterpret_cast<std::uintptr_t>(node) & 1u) != 0; }
std::uint32_t leaf_primitive(const void* node) {
  return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(node) >> 1);
}

std::uint32_t primitive_of(const RTCBuildPrimitive& p) { return p.primID; }

void* create_node(RTCThreadLocalAllocator allocator, unsigned child_count, void*) {
  void* memory = rtcThreadLocalAlloc(allocator, 8 + sizeof(BuildNode::Child) * child_count, 16);
  auto* node = static_cast<BuildNode*>(memory);
  node->child_count = child_count;
  return node;
}

void set_children(void* node, void** children, unsigned count, void*) {
  for (unsigned i = 0; i < count; ++i) static_cast<BuildNode*>(node)->children[i].node = children[i];
}

void set_bounds(void* node, const RTCBounds** bounds, unsigned count, void*) {
  for (unsigned i = 0; i < count; ++i) {
    BuildNode::Child& child = static_cast<BuildNode*>(node)->children[i];
    const RTCBounds& b = *bounds[i];
    std::tie(child.lower[0], child.lower[1], child.lower[2]) = std::tie(b.lower_x, b.lower_y, b.lower_z);
    std::tie(child.upper[0], child.upper[1], child.upper[2]) = std::tie(b.upper_x, b.upper_y, b.upper_z);
  }
}

void* create_leaf(RTCThreadLocalAllocator, const RTCBuildPrimitive* primitives, [[maybe_unused]] std::size_t count,
                  void*) {
  assert(count == 1);
  return leaf_pointer(primitive_of(primitives[0]));
}

Box to_box(const BuildNode::Child& child) {
  Box box;
  box.lower = {child.lower[0], child.lower[1], child.lower[2]};
  box.upper = {child.upper[0], child.upper[1], child.upper[2]};
  return box;
}

unsigned flatten(const BuildNode* node, Tree& tree, std::uint32_t index) {
  const auto first = static_cast<std::uint32_t>(tree.children.size());
  tree.internals[index] = {first, node->child_count};
  tree.children.resize(first + node->child_count);
  unsigned deepest = 1;
  for (unsigned i = 0; i < node->child_count; ++i) {
    TreeChild child;
    child.box = to_box(node->children[i]);
    child.leaf = is_leaf(node->children[i].node);
    if (child.leaf) {
      child.index = leaf_primitive(node->children[i].node);
    } else {
      child.index = static_cast<std::uint32_t>(tree.internals.size());
      tree.internals.emplace_back();
    }
    tree.children[first + i] = child;
    if (!child.leaf) {
      deepest = std::max(deepest, flatten(static_cast<const BuildNode*>(node->children[i].node), tree, child.index));
    }
  }
  return deepest + 1;
}

}  // namespace

Tree build_tree(std::size_t count, const std::function<Box(std::size_t)>& box_of, unsigned width) {
  Tree tree;
  tree.internals.emplace_back();
  if (count == 0) {
    tree.bounds.lower = tree.bounds.upper = glm::vec3(0.0f);
    tree.height = 1;
    return tree;
  }
  std::vector<RTCBuildPrimitive> primitives(count);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count), [&](const tbb::blocked_range<std::size_t>& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      const Box box = box_of(i);
      primitives[i] = {box.lower.x, box.lower.y, box.lower.z, 0,
                       box.upper.x, box.upper.y, box.upper.z, static_cast<unsigned>(i)};
    }
  });
  for (std::size_t i = 0; i < count; ++i) {
    tree.bounds.extend(glm::vec3(primitives[i].lower_x, primitives[i].lower_y, primitives[i].lower_z));
    tree.bounds.extend(glm::vec3(primitives[i].upper_x, primitives[i].upper_y, primitives[i].upper_z));
  }

  struct Handles {
    RTCDevice device = rtcNewDevice(nullptr);
    RTCBVH bvh = device != nullptr ? rtcNewBVH(device) : nullptr;
    ~Handles() {
      if (bvh != nullptr) rtcReleaseBVH(bvh);
      if (device != nullptr) rtcReleaseDevice(device);
    }
  } handles;
  if (handles.bvh == nullptr) throw std::runtime_error("Embree device cannot be created");

  RTCBuildArguments arguments = rtcDefaultBuildArguments();
  arguments.byteSize = sizeof arguments;
  arguments.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
  arguments.maxBranchingFactor = width;
  arguments.minLeafSize = 1;
  arguments.maxLeafSize = 1;
  arguments.bvh = handles.bvh;
  arguments.primitives = primitives.data();
  arguments.primitiveCount = count;
  arguments.primitiveArrayCapacity = count;
  arguments.createNode = create_node;
  arguments.setNodeChildren = set_children;
  arguments.setNodeBounds = set_bounds;
  arguments.createLeaf = create_leaf;

  const auto start = std::chrono::steady_clock::now();
  void* root = rtcBuildBVH(&arguments);
  tree.build_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (root == nullptr) {
    throw std::runtime_error("rtcBuildBVH failed with Embree error " +
                             std::to_string(rtcGetDeviceError(handles.device)));
  }
  primitives = {};
  if (is_leaf(root)) {
    tree.internals[0] = {0, 1};
    tree.children.push_back({tree.bounds, leaf_primitive(root), true});
    tree.height = 2;
    return tree;
  }
  tree.children.reserve(count + count / 2);
  tree.internals.reserve(count / 2 + 1);
  tree.height = flatten(static_cast<const BuildNode*>(root), tree, 0);
  // Embree leaves out primitives whose boxes are not finite; loading admits none, and a loss must not be silent.
  assert(tree.children.size() == tree.internals.size() - 1 + count);
  return tree;
}

}  // namespace grtx::frontend
