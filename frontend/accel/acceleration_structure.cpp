#include "grtx/frontend/accel/acceleration_structure.h"

#include <algorithm>
#include <cassert>
#include <chrono>

#include "grtx/base/error.h"
#include "grtx/base/nearest_name.h"
#include "grtx/base/stopwatch.h"
#include "grtx/frontend/accel/embree_builder.h"
#include "grtx/frontend/accel/tree_packer.h"

namespace grtx::frontend {
namespace {

// The leaves of a monolithic tree over proxies in the world.
struct WorldLeaf {
  const PreparedGaussians& gaussians;
  const Proxy& proxy;
  std::uint32_t faces = proxy.is_sphere() ? 1 : proxy.faces();

  void prefetch(std::uint32_t index) const { gaussians.prefetch(index / faces); }
  void operator()(NodeImage& image, std::uint64_t address, std::uint32_t index) const {
    if (proxy.is_sphere()) {
      const GaussianRecord& record = gaussians.record(index);
      image.write_procedural(address, index, record.to_unit, record.mean);
      return;
    }
    const std::uint32_t g = index / faces;
    const auto& [a, b, c] = proxy.triangles()[index % faces];
    const auto& vertices = proxy.vertices();
    image.write_triangle(address, index, gaussians.to_world(g, vertices[a]), gaussians.to_world(g, vertices[b]),
                         gaussians.to_world(g, vertices[c]));
  }
};

// The leaves of a TLAS: one instance of the shared BLAS a Gaussian.
struct InstanceLeaf {
  const PreparedGaussians& gaussians;
  std::uint64_t blas_header;
  std::uint64_t blas_root;

  void prefetch(std::uint32_t g) const { gaussians.prefetch(g); }
  void operator()(NodeImage& image, std::uint64_t address, std::uint32_t g) const {
    const GaussianRecord& record = gaussians.record(g);
    const glm::vec3 columns[3] = {gaussians.to_world(g, {1, 0, 0}) - record.mean,
                                  gaussians.to_world(g, {0, 1, 0}) - record.mean,
                                  gaussians.to_world(g, {0, 0, 1}) - record.mean};
    image.write_instance(address, g, blas_header, blas_root, record.to_unit, columns, record.mean);
  }
};

// The leaves of the BLAS: the proxy in unit space.
struct UnitLeaf {
  const Proxy& proxy;

  void operator()(NodeImage& image, std::uint64_t address, std::uint32_t index) const {
    if (proxy.is_sphere()) {
      image.write_procedural(address, index);
      return;
    }
    const auto& [a, b, c] = proxy.triangles()[index];
    const auto& vertices = proxy.vertices();
    image.write_triangle(address, index, vertices[a], vertices[b], vertices[c]);
  }
};

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
    case AccelKind::tlas_sphere:
      return ProxyKind::sphere;
  }
  return ProxyKind::sphere;
}

AccelerationStructure::AccelerationStructure(const PreparedGaussians& gaussians, const AccelOptions& options)
    : options_(options), proxy_(proxy_of(options.kind)), image_(options.width, 0) {
  const std::size_t count = gaussians.size();
  const unsigned width = options.width;
  const bool sphere = proxy_.is_sphere();
  const NodeKind primitive_kind = sphere ? NodeKind::procedural : NodeKind::triangle;
  const std::size_t faces = sphere ? 1 : proxy_.faces();

  if (!two_level()) {
    const Tree tree = build_tree(
        count * faces, faces,
        [&](std::size_t begin, std::size_t end, PrimitiveBox* boxes) {
          gaussians.write_face_boxes(begin / faces, end / faces, proxy_, boxes);
        },
        width);
    build_seconds_ = tree.build_seconds;
    height_ = tree.height;
    const auto start = std::chrono::steady_clock::now();
    image_ = NodeImage(width, packed_bytes(tree, primitive_kind, width), options_.box_bits);
    root_ = TreePacker(image_, tree, primitive_kind, WorldLeaf{gaussians, proxy_}, true).pack(image_.size());
    pack_seconds_ = seconds_since(start);
    counts_.internal = tree.internals;
    (sphere ? counts_.procedural : counts_.triangle) = count * faces;
  } else {
    const Tree blas = build_tree(
        faces, [&](std::size_t i) { return proxy_.face_box(static_cast<unsigned>(i)); }, width);
    const Tree tlas = build_tree(
        count, 1,
        [&](std::size_t begin, std::size_t end, PrimitiveBox* boxes) {
          gaussians.write_instance_boxes(begin, end, proxy_, options.corner_bounds, boxes);
        },
        width);
    build_seconds_ = tlas.build_seconds + blas.build_seconds;
    height_ = tlas.height;
    blas_height_ = blas.height;
    const auto start = std::chrono::steady_clock::now();
    const std::uint64_t tlas_bytes = packed_bytes(tlas, NodeKind::instance, width);
    image_ = NodeImage(width, tlas_bytes + packed_bytes(blas, primitive_kind, width), options_.box_bits);
    blas_header_ = tlas_bytes;
    // The BLAS is packed behind the TLAS; its root follows its header.
    blas_root_ = blas_header_ + traces::kHeaderBytes;
    root_ = TreePacker(image_, tlas, NodeKind::instance, InstanceLeaf{gaussians, blas_header_, blas_root_}, true)
                .pack(tlas_bytes);
    [[maybe_unused]] const std::uint64_t packed_root =
        TreePacker(image_, blas, primitive_kind, UnitLeaf{proxy_}).pack(image_.size() - tlas_bytes);
    assert(packed_root == blas_root_);
    pack_seconds_ = seconds_since(start);
    counts_.internal = tlas.internals;
    counts_.instance = count;
    counts_.blas_nodes = blas.internals + faces;
  }
  assert(image_.allocated() == image_.size());
}

}  // namespace grtx::frontend
