#include "frontend/acceleration_structure.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <chrono>
#include <functional>

#include "base/error.h"
#include "base/nearest_name.h"
#include "frontend/embree_builder.h"

namespace grtx::frontend {
namespace {

// Writes one leaf at `address` for tree leaf `index`.
using LeafWriter = std::function<void(NodeImage&, std::uint64_t address, std::uint32_t index)>;

/// Packs a tree depth first: a node's children lie together, then each child's subtree follows.
class Packer {
 public:
  Packer(NodeImage& image, const Tree& tree, NodeKind leaf_kind, LeafWriter write_leaf)
      : image_(image), tree_(tree), leaf_kind_(leaf_kind), write_leaf_(std::move(write_leaf)) {}

  /// Writes header and nodes; returns the root's address.
  std::uint64_t pack() {
    const std::uint64_t header = image_.allocate(traces::kHeaderBytes);
    const std::uint64_t root = image_.allocate(traces::internal_bytes(image_.width()));
    image_.write_header(header, root, tree_.bounds);
    pack_node(0, root);
    return root;
  }

 private:
  void pack_node(std::uint32_t index, std::uint64_t address) {
    const TreeNode& node = tree_.internals[index];
    std::array<ChildRecord, traces::kMaxWidth> records;
    std::array<std::uint64_t, traces::kMaxWidth> addresses{};
    std::uint64_t bytes = 0;
    for (unsigned i = 0; i < node.child_count; ++i) {
      const TreeChild& child = tree_.children[node.first_child + i];
      records[i] = {child.box, child.leaf ? leaf_kind_ : NodeKind::internal};
      addresses[i] = bytes;
      bytes += traces::node_bytes(records[i].kind, image_.width());
    }
    const std::uint64_t base = image_.allocate(bytes);
    image_.write_internal(address, base, records.data(), node.child_count);
    for (unsigned i = 0; i < node.child_count; ++i) {
      const TreeChild& child = tree_.children[node.first_child + i];
      if (child.leaf) {
        write_leaf_(image_, base + addresses[i], child.index);
      } else {
        pack_node(child.index, base + addresses[i]);
      }
    }
  }

  NodeImage& image_;
  const Tree& tree_;
  NodeKind leaf_kind_;
  LeafWriter write_leaf_;
};

std::uint64_t packed_bytes(const Tree& tree, NodeKind leaf_kind, unsigned width) {
  const auto leaves = static_cast<std::uint64_t>(
      std::count_if(tree.children.begin(), tree.children.end(), [](const TreeChild& c) { return c.leaf; }));
  return traces::kHeaderBytes + tree.internals.size() * traces::internal_bytes(width) +
         leaves * traces::node_bytes(leaf_kind, width);
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

const std::vector<std::string>& accel_names() {
  static const std::vector<std::string> names = {"tri20", "tri80", "ellipsoid", "tlas-tri20", "tlas-tri80",
                                                 "tlas-sphere"};
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
    case AccelKind::tlas_tri20: return ProxyKind::icosahedron20;
    case AccelKind::tri80:
    case AccelKind::tlas_tri80: return ProxyKind::icosphere80;
    case AccelKind::ellipsoid:
    case AccelKind::tlas_sphere: return ProxyKind::sphere;
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
    image_ = NodeImage(width, packed_bytes(tree, primitive_kind, width));
    root_ = Packer(image_, tree, primitive_kind, [&](NodeImage& image, std::uint64_t address, std::uint32_t index) {
              if (sphere) {
                image.write_procedural(address, index);
                return;
              }
              const auto g = static_cast<std::uint32_t>(index / faces);
              const auto& [a, b, c] = proxy_.triangles()[index % faces];
              const auto& vertices = proxy_.vertices();
              image.write_triangle(address, index, gaussians.to_world(g, vertices[a]),
                                   gaussians.to_world(g, vertices[b]), gaussians.to_world(g, vertices[c]));
            }).pack();
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
    image_ = NodeImage(width, tlas_bytes + packed_bytes(blas, primitive_kind, width));
    blas_header_ = tlas_bytes;
    // The BLAS is packed behind the TLAS; its root follows its header.
    blas_root_ = blas_header_ + traces::kHeaderBytes;
    root_ = Packer(image_, tlas, NodeKind::instance, [&](NodeImage& image, std::uint64_t address, std::uint32_t g) {
              const GaussianRecord& record = gaussians.record(g);
              const glm::vec3 columns[3] = {
                  gaussians.to_world(g, {1, 0, 0}) - record.mean, gaussians.to_world(g, {0, 1, 0}) - record.mean,
                  gaussians.to_world(g, {0, 0, 1}) - record.mean};
              image.write_instance(address, g, blas_header_, blas_root_, record.to_unit, columns, record.mean);
            }).pack();
    [[maybe_unused]] const std::uint64_t packed_root =
        Packer(image_, blas, primitive_kind, [&](NodeImage& image, std::uint64_t address, std::uint32_t index) {
          if (sphere) {
            image.write_procedural(address, index);
            return;
          }
          const auto& [a, b, c] = proxy_.triangles()[index];
          const auto& vertices = proxy_.vertices();
          image.write_triangle(address, index, vertices[a], vertices[b], vertices[c]);
        }).pack();
    assert(packed_root == blas_root_);
    pack_seconds_ = seconds_since(start);
    counts_.internal = tlas.internals.size();
    counts_.instance = count;
    counts_.blas_nodes = blas.internals.size() + faces;
  }
  assert(image_.allocated() == image_.size());
}

}  // namespace grtx::frontend
