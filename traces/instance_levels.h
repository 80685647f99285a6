// SPDX-License-Identifier: Apache-2.0
// The levels of an acceleration structure: which instance leaves lead to a node, and where an instance leaf leads: to
// the shared BLAS, or, with three levels, from the scene TLAS to an object's TLAS.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "grtx/traces/header.h"

namespace grtx::traces {

/// Addresses of the instance leaves above a node, in units; 0 if there is none.
struct InstancePath {
  std::uint32_t scene = 0;     ///< leaf of the scene TLAS, for nodes inside an object
  std::uint32_t instance = 0;  ///< leaf of the TLAS or of an object's TLAS, for nodes inside the BLAS
  friend bool operator==(const InstancePath&, const InstancePath&) = default;
};

/// An entry of a checkpoint buffer: a child of a node, with the instance leaves above it.
struct NodeReference {
  std::uint32_t parent = 0;  ///< index of the node among those of its group
  std::uint32_t slot = 0;
  InstancePath path;
};

/// Roots are numbered: 0 the (scene) TLAS or monolithic BVH, 1 the BLAS, 2 and up the objects' TLASes.
class InstanceLevels {
 public:
  static constexpr std::uint32_t kRoot = 0;
  static constexpr std::uint32_t kBlasRoot = 1;
  static constexpr std::uint32_t kFirstObjectRoot = 2;
  static constexpr std::uint32_t kNoRoot = 0xFFFFFFFF;

  InstanceLevels() = default;
  explicit InstanceLevels(const Header& header)
      : blas_begin_(header.two_level ? in_units(header, header.blas_base) : kNoBlas),
        objects_begin_(in_units(header, header.objects_base())) {
    for (const std::uint64_t root : header.object_roots) object_roots_.push_back(in_units(header, root));
    for (const SceneLeaf& leaf : header.scene_leaves) leaves_.push_back({in_units(header, leaf.address), leaf.object});
  }

  std::uint32_t roots() const { return kFirstObjectRoot + static_cast<std::uint32_t>(object_roots_.size()); }
  bool is_blas(std::uint32_t address) const { return address >= blas_begin_; }
  /// Whether the node is in the scene TLAS; always false without one.
  bool is_scene(std::uint32_t address) const { return address < objects_begin_; }
  /// Whether the node is in an object's TLAS or in the BLAS below it.
  bool is_object(std::uint32_t address) const { return objects_begin_ != 0 && address >= objects_begin_; }
  /// Number of the root to which the instance leaf at `leaf` leads; kNoRoot if the header lists no such leaf.
  std::uint32_t root_below(std::uint32_t leaf) const {
    if (!is_scene(leaf)) return kBlasRoot;
    const auto found = std::lower_bound(leaves_.begin(), leaves_.end(), leaf,
                                        [](const Leaf& l, std::uint32_t address) { return l.address < address; });
    return found != leaves_.end() && found->address == leaf ? kFirstObjectRoot + found->object : kNoRoot;
  }
  /// Address of the object root with number `root`, in units.
  std::uint32_t object_root(std::uint32_t root) const { return object_roots_[root - kFirstObjectRoot]; }
  /// Path of the root below the instance leaf at `leaf`, whose own path is `path`.
  InstancePath below(const InstancePath& path, std::uint32_t leaf) const {
    return is_scene(leaf) ? InstancePath{leaf, 0} : InstancePath{path.scene, leaf};
  }

 private:
  static constexpr std::uint32_t kNoBlas = std::numeric_limits<std::uint32_t>::max();
  struct Leaf {
    std::uint32_t address = 0;
    std::uint32_t object = 0;
  };
  static std::uint32_t in_units(const Header& header, std::uint64_t address) {
    return static_cast<std::uint32_t>(address / header.node_sizes().unit());
  }

  std::uint32_t blas_begin_ = kNoBlas;
  std::uint32_t objects_begin_ = 0;
  std::vector<std::uint32_t> object_roots_;
  std::vector<Leaf> leaves_;  ///< leaves of the scene TLAS, ascending
};

}  // namespace grtx::traces
