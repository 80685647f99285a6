// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/gaussian/face_patches.h"

#include <algorithm>
#include <cassert>

namespace grtx::frontend {
namespace {

using Faces = std::array<std::uint16_t, 4>;

// Of the 1,432 ways to cut the icosahedron into five connected patches of four faces this one has the smallest boxes
// under transforms like those of trained Gaussians: four fans and a strip (docs/model/node-image.md).
constexpr std::array<Faces, 5> kIcosahedron = {
    {{2, 3, 4, 0}, {1, 15, 11, 10}, {5, 6, 8, 9}, {7, 13, 14, 18}, {12, 17, 16, 19}}};

// The four faces of a subdivided face: the middle one, then the three at its corners.
Faces quarters_of(unsigned face) {
  const auto first = static_cast<std::uint16_t>(4 * face);
  return {static_cast<std::uint16_t>(first + 3), first, static_cast<std::uint16_t>(first + 1),
          static_cast<std::uint16_t>(first + 2)};
}

// Orders the faces of `left` so that each shares an edge with one before it.
FacePatch make_patch(const Proxy& proxy, unsigned number, std::vector<std::uint16_t> left) {
  FacePatch patch;
  patch.code = static_cast<std::uint32_t>(left.size()) | number << 3;
  std::size_t vertices = 0, faces = 0;
  const auto place = [&](std::uint16_t vertex) {
    return static_cast<std::size_t>(std::find(patch.vertices.data(), patch.vertices.data() + vertices, vertex) -
                                    patch.vertices.data());
  };
  const auto take = [&](std::size_t i) {
    patch.faces[faces++] = left[i];
    patch.object_box.extend(proxy.face_box(left[i]));
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(i));
  };
  for (const std::uint16_t v : proxy.triangles()[left[0]]) patch.vertices[vertices++] = v;
  take(0);
  while (!left.empty()) {
    bool taken = false;
    for (std::size_t i = 0; i < left.size() && !taken; ++i) {
      const auto& corners = proxy.triangles()[left[i]];
      for (unsigned last = 0; last < 3 && !taken; ++last) {  // the corner that is new; keeps the winding
        const std::size_t a = place(corners[(last + 1) % 3]), b = place(corners[(last + 2) % 3]);
        if (a == vertices || b == vertices) continue;
        assert(place(corners[last]) == vertices);
        patch.code |= static_cast<std::uint32_t>(a | b << 3) << (8 + 6 * (faces - 1));
        patch.vertices[vertices++] = corners[last];
        taken = true;
      }
      if (taken) take(i);
    }
    assert(taken);
  }
  return patch;
}

}  // namespace

FacePatches::FacePatches(const Proxy& proxy) {
  const unsigned count = proxy.is_sphere() ? 1 : proxy.faces() / 4;
  for (unsigned i = 0; i < count; ++i) {
    if (proxy.is_sphere()) {
      patches_.emplace_back();
      patches_.back().object_box = proxy.face_box(0);
      continue;
    }
    const Faces faces = proxy.kind() == ProxyKind::icosahedron20 ? kIcosahedron[i] : quarters_of(i);
    patches_.push_back(make_patch(proxy, i, {faces.begin(), faces.end()}));
    for (const std::uint16_t face : faces) patch_of_[face] = static_cast<std::uint8_t>(i);
  }
}

}  // namespace grtx::frontend
