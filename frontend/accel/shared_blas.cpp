// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/accel/shared_blas.h"

#include "grtx/frontend/accel/tree_packer.h"

namespace grtx::frontend {
namespace {

struct UnitLeaf {
  const Proxy& proxy;
  const FacePatches& patches;

  void operator()(NodeImage& image, std::uint64_t address, std::uint32_t index) const {
    const bool compact = image.sizes().layout() == traces::NodeLayout::compact;
    if (proxy.is_sphere()) {
      const glm::vec3 identity[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
      compact ? image.write_procedural(address, index, proxy.face_box(0), identity, glm::vec3(0.0f))
              : image.write_procedural(address, index);
      return;
    }
    const auto& vertices = proxy.vertices();
    if (compact) {
      const FacePatch& patch = patches.patches()[index];
      PatchRecord leaf{0, patch.code, {}};
      for (std::size_t i = 0; i < leaf.vertices.size(); ++i) leaf.vertices[i] = vertices[patch.vertices[i]];
      image.write_patch(address, leaf, index);
      return;
    }
    const auto& [a, b, c] = proxy.triangles()[index];
    image.write_triangle(address, index, vertices[a], vertices[b], vertices[c]);
  }
};

Tree tree_of(const Proxy& proxy, const FacePatches& patches, bool compact, unsigned width) {
  if (compact || proxy.is_sphere()) {
    return build_tree(
        patches.count(), [&](std::size_t i) { return patches.patches()[i].object_box; }, width);
  }
  return build_tree(
      proxy.faces(), [&](std::size_t i) { return proxy.face_box(static_cast<unsigned>(i)); }, width);
}

}  // namespace

SharedBlas::SharedBlas(const Proxy& proxy, const FacePatches& patches, traces::NodeLayout layout, unsigned width)
    : proxy_(proxy),
      patches_(patches),
      sizes_(layout, width),
      tree_(tree_of(proxy, patches, layout == traces::NodeLayout::compact, width)) {}

std::uint64_t SharedBlas::bytes() const { return packed_bytes(tree_, leaf_kind(), sizes_); }

std::uint64_t SharedBlas::pack(NodeImage& image) const {
  return TreePacker(image, tree_, leaf_kind(), UnitLeaf{proxy_, patches_}).pack(bytes());
}

}  // namespace grtx::frontend
