#include "frontend/acceleration_structure.h"

#include <algorithm>
#include <cassert>
#include <chrono>

#include "base/error.h"
#include "base/nearest_name.h"
#include "frontend/embree_builder.h"
#include "frontend/tree_packer.h"

namespace grtx::frontend {
namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

const std::vector<std::string>& accel_names() {
  static const std::vector<std::string> names = {"tri20",      "tri80",      "ellipsoid",
                                                 "tlas-tri20", "tlas-tri80", "tlas-sphere"};
  return names;
}

AccelKind accel_from_name(const std::string& name) {
  const auto& names = accel_names();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    throw Error("--accel", "'" + name + "'", "is unknown; did you mean '" + nearest_name(name, names) + "'?");
  }
  return static_cast<AccelKind>(found - names.begin());
}

std::string accel_name(AccelKind kind) { return accel_names()[static_cast<std::size_t>(kind)]; }

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
        count * faces,
        [&](std::size_t i) {
          return gaussians.face_box(static_cast<std::uint32_t>(i / faces), proxy_, static_cast<unsigned>(i % faces));
        },
        width);
    build_seconds_ = tree.build_seconds;
    height_ = tree.height;
    const auto start = std::chrono::steady_clock::now();
    image_ = NodeImage(width, packed_bytes(tree, primitive_kind, width), options_.box_bits);
    root_ = TreePacker(
                image_, tree, primitive_kind,
                [&](NodeImage& image, std::uint64_t address, std::uint32_t index) {
                  if (sphere) {
                    image.write_procedural(address, index);
                    return;
                  }
                  const auto g = static_cast<std::uint32_t>(index / faces);
                  const auto& [a, b, c] = proxy_.triangles()[index % faces];
                  const auto& vertices = proxy_.vertices();
                  image.write_triangle(address, index, gaussians.to_world(g, vertices[a]),
                                       gaussians.to_world(g, vertices[b]), gaussians.to_world(g, vertices[c]));
                },
                true)
                .pack(image_.size());
    pack_seconds_ = seconds_since(start);
    counts_.internal = tree.internals.size();
    (sphere ? counts_.procedural : counts_.triangle) = count * faces;
  } else {
    const Tree blas = build_tree(
        faces, [&](std::size_t i) { return proxy_.face_box(static_cast<unsigned>(i)); }, width);
    const Tree tlas = build_tree(
        count,
        [&](std::size_t i) {
          return gaussians.instance_box(static_cast<std::uint32_t>(i), proxy_, options.corner_bounds);
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
    root_ = TreePacker(
                image_, tlas, NodeKind::instance,
                [&](NodeImage& image, std::uint64_t address, std::uint32_t g) {
                  const GaussianRecord& record = gaussians.record(g);
                  const glm::vec3 columns[3] = {gaussians.to_world(g, {1, 0, 0}) - record.mean,
                                                gaussians.to_world(g, {0, 1, 0}) - record.mean,
                                                gaussians.to_world(g, {0, 0, 1}) - record.mean};
                  image.write_instance(address, g, blas_header_, blas_root_, record.to_unit, columns, record.mean);
                },
                true)
                .pack(tlas_bytes);
    [[maybe_unused]] const std::uint64_t packed_root =
        TreePacker(image_, blas, primitive_kind, [&](NodeImage& image, std::uint64_t address, std::uint32_t index) {
          if (sphere) {
            image.write_procedural(address, index);
            return;
          }
          const auto& [a, b, c] = proxy_.triangles()[index];
          const auto& vertices = proxy_.vertices();
          image.write_triangle(address, index, vertices[a], vertices[b], vertices[c]);
        }).pack(image_.size() - tlas_bytes);
    assert(packed_root == blas_root_);
    pack_seconds_ = seconds_since(start);
    counts_.internal = tlas.internals.size();
    counts_.instance = count;
    counts_.blas_nodes = blas.internals.size() + faces;
  }
  assert(image_.allocated() == image_.size());
}

}  // namespace grtx::frontend
