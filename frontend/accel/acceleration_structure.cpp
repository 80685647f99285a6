// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/accel/acceleration_structure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <chrono>

#include "grtx/base/error.h"
#include "grtx/base/memory_purpose.h"
#include "grtx/base/nearest_name.h"
#include "grtx/base/stopwatch.h"
#include "grtx/frontend/accel/embree_builder.h"
#include "grtx/frontend/accel/shared_blas.h"
#include "grtx/frontend/accel/tree_packer.h"

namespace grtx::frontend {
namespace {

// Number of primitive leaves per proxy.
unsigned leaves_of(const Proxy& proxy, const FacePatches& patches, bool compact) {
  return compact || proxy.is_sphere() ? patches.count() : proxy.faces();
}

// Writes the leaves of a monolithic tree: proxies in world space.
struct WorldLeaf {
  const PreparedGaussians& gaussians;
  const Proxy& proxy;
  const FacePatches& patches;
  bool compact;
  std::uint32_t leaves = leaves_of(proxy, patches, compact);  ///< per Gaussian

  void prefetch(std::uint32_t index) const { gaussians.prefetch(index / leaves); }
  bool wide(std::uint32_t index) const { return proxy.is_sphere() && gaussians.wide(index); }
  void operator()(NodeImage& image, std::uint64_t address, std::uint32_t index) const {
    if (compact) return write_compact(image, address, index);
    if (proxy.is_sphere() && is_quantised(image.sizes().layout()) && !gaussians.wide(index))
      return image.write_quantised(address, gaussians.code(index));
    if (proxy.is_sphere()) {
      const GaussianRecord& record = gaussians.record(index);
      image.write_procedural(address, index, record.to_unit, record.mean);
      return;
    }
    const std::uint32_t g = index / leaves;
    const auto& [a, b, c] = proxy.triangles()[index % leaves];
    const auto& vertices = proxy.vertices();
    image.write_triangle(address, index, gaussians.to_world(g, vertices[a]), gaussians.to_world(g, vertices[b]),
                         gaussians.to_world(g, vertices[c]));
  }
  void write_compact(NodeImage& image, std::uint64_t address, std::uint32_t index) const {
    const std::uint32_t g = index / leaves;
    if (proxy.is_sphere()) {
      const GaussianRecord& record = gaussians.record(g);
      image.write_procedural(address, g, gaussians.face_box(g, proxy, 0), record.to_unit, record.mean);
      return;
    }
    const FacePatch& patch = patches.patches()[index % leaves];
    PatchRecord leaf{g, patch.code, {}};
    for (std::size_t i = 0; i < leaf.vertices.size(); ++i) {
      leaf.vertices[i] = gaussians.to_world(g, proxy.vertices()[patch.vertices[i]]);
    }
    image.write_patch(address, leaf, index);
  }
};

// Writes the leaves of a TLAS: one instance of the shared BLAS per Gaussian.
struct InstanceLeaf {
  const PreparedGaussians& gaussians;
  std::uint64_t blas_header;
  std::uint64_t blas_root;

  void prefetch(std::uint32_t g) const { gaussians.prefetch(g); }
  bool wide(std::uint32_t g) const { return gaussians.wide(g); }
  void operator()(NodeImage& image, std::uint64_t address, std::uint32_t g) const {
    const GaussianRecord& record = gaussians.record(g);
    if (is_quantised(image.sizes().layout())) {
      return gaussians.wide(g) ? image.write_compressed_instance(address, g, blas_root, record.to_unit, record.mean)
                               : image.write_quantised(address, gaussians.code(g));
    }
    const glm::vec3 columns[3] = {gaussians.to_world(g, {1, 0, 0}) - record.mean,
                                  gaussians.to_world(g, {0, 1, 0}) - record.mean,
                                  gaussians.to_world(g, {0, 0, 1}) - record.mean};
    image.write_instance(address, g, blas_header, blas_root, record.to_unit, columns, record.mean);
  }
};

/// Message for hosts with too little memory.
std::string memory_of(AccelKind kind, std::size_t gaussians, std::size_t leaves) {
  const auto gigabytes = [&](AccelKind built) {
    return 1e-9 * static_cast<double>(bytes_to_build(built, gaussians, leaves));
  };
  std::string text =
      fmt::format("a structure {} of {} Gaussians takes some {:.2g} GB", name_of(kind), gaussians, gigabytes(kind));
  if (!is_two_level(kind))
    text += fmt::format("; --accel tlas-tri20 takes {:.2g} GB", gigabytes(AccelKind::tlas_tri20));
  return text;
}

}  // namespace

AccelKind accel_from_name(const std::string& name) {
  if (const auto kind = from_name<AccelKind>(name)) return *kind;
  throw Error("--accel", "'" + name + "'",
              "is unknown; did you mean '" + nearest_name(name, names_of<AccelKind>()) + "'?");
}

std::string accel_name(AccelKind kind) { return std::string(name_of(kind)); }

ProxyKind proxy_of(AccelKind kind) {
  switch (kind) {
    case AccelKind::tri20:
    case AccelKind::tlas_tri20:
      return ProxyKind::icosahedron20;
    case AccelKind::tri80:
    case AccelKind::tlas_tri80:
      return ProxyKind::icosphere80;
    case AccelKind::ellipsoid:
    case AccelKind::box:
    case AccelKind::tlas_sphere:
    case AccelKind::tlas_box:
      return ProxyKind::sphere;
  }
  return ProxyKind::sphere;
}

std::uint64_t bytes_to_build(AccelKind kind, std::size_t gaussians, std::size_t leaves) {
  constexpr std::uint64_t kLeaf = 102, kInstance = 330;
  return gaussians * (is_two_level(kind) ? kInstance : leaves * kLeaf);
}

AccelerationStructure::AccelerationStructure(const PreparedGaussians& gaussians, const AccelOptions& options)
    : options_(options), proxy_(proxy_of(options.kind)), patches_(proxy_), image_(options.width, 0) {
  assert(gaussians.quantised() || !is_quantised(options.layout));
  const std::size_t leaves = leaves_of(proxy_, patches_, options.layout == NodeLayout::compact);
  // Triangles in the world are as in other layouts, whatever they are the proxy of.
  const bool coded_leaves = is_quantised(options.layout) && (proxy_.is_sphere() || two_level());
  const IsWide is_wide = coded_leaves && gaussians.wide_count() != 0
                             ? IsWide([&](std::uint32_t g) { return gaussians.wide(g); })
                             : nullptr;
  const MemoryPurpose purpose(memory_of(options.kind, gaussians.size(), leaves));
  if (two_level()) {
    build_two_level(gaussians, leaves, is_wide);
  } else {
    build_monolithic(gaussians, leaves, is_wide);
  }
  if (is_quantised(options.layout)) image_.write_mean_grid(0, gaussians.mean_grid());
  assert(image_.allocated() == image_.size());
}

void AccelerationStructure::build_monolithic(const PreparedGaussians& gaussians, std::size_t leaves,
                                             const IsWide& is_wide) {
  const bool sphere = proxy_.is_sphere(), compact = options_.layout == NodeLayout::compact;
  const NodeKind primitive_kind = sphere ? NodeKind::procedural : NodeKind::triangle;
  const Tree tree = build_tree(
      gaussians.size() * leaves, leaves,
      [&](std::size_t begin, std::size_t end, PrimitiveBox* boxes) {
        if (compact && !sphere) {
          gaussians.write_patch_boxes(begin / leaves, end / leaves, proxy_, patches_, boxes);
        } else {
          gaussians.write_face_boxes(begin / leaves, end / leaves, proxy_, boxes);
        }
      },
      options_.width, is_wide);
  build_seconds_ = tree.build_seconds;
  counts_.wide = tree.wide;
  height_ = tree.height;
  const auto start = std::chrono::steady_clock::now();
  const traces::NodeSizes sizes(options_.layout, options_.width);
  image_ = NodeImage(options_.width, packed_bytes(tree, primitive_kind, sizes), options_.box_bits, options_.layout);
  root_ = TreePacker(image_, tree, primitive_kind, WorldLeaf{gaussians, proxy_, patches_, compact}, true)
              .pack(image_.size());
  pack_seconds_ = seconds_since(start);
  counts_.internal = tree.internals;
  (sphere ? counts_.procedural : counts_.triangle) = gaussians.size() * leaves;
}

void AccelerationStructure::build_two_level(const PreparedGaussians& gaussians, std::size_t leaves,
                                            const IsWide& is_wide) {
  const SharedBlas blas(proxy_, patches_, options_.layout, options_.width);
  const Tree tlas = build_tree(
      gaussians.size(), 1,
      [&](std::size_t begin, std::size_t end, PrimitiveBox* boxes) {
        gaussians.write_instance_boxes(begin, end, proxy_, options_.corner_bounds, boxes);
      },
      options_.width, is_wide);
  build_seconds_ = tlas.build_seconds + blas.tree().build_seconds;
  counts_.wide = tlas.wide;
  height_ = tlas.height;
  blas_height_ = blas.tree().height;
  const auto start = std::chrono::steady_clock::now();
  const traces::NodeSizes sizes(options_.layout, options_.width);
  const std::uint64_t tlas_bytes = packed_bytes(tlas, NodeKind::instance, sizes);
  image_ = NodeImage(options_.width, tlas_bytes + blas.bytes(), options_.box_bits, options_.layout);
  blas_header_ = tlas_bytes;
  // The BLAS is packed behind the TLAS; its root follows its header.
  blas_root_ = blas_header_ + sizes.header_bytes();
  root_ = TreePacker(image_, tlas, NodeKind::instance, InstanceLeaf{gaussians, blas_header_, blas_root_}, true)
              .pack(tlas_bytes);
  [[maybe_unused]] const std::uint64_t packed_root = blas.pack(image_);
  assert(packed_root == blas_root_);
  pack_seconds_ = seconds_since(start);
  counts_.internal = tlas.internals;
  counts_.instance = gaussians.size();
  counts_.blas_nodes = blas.tree().internals + leaves;
}

}  // namespace grtx::frontend
