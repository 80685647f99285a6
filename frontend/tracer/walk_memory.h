// SPDX-License-Identifier: Apache-2.0
// One ray's knowledge of the tree: every box, instance and leaf that it tested. A ray that restarts at the root, or
// resumes from a checkpoint, meets the same nodes again with the same results; only t_min and t_max differ.
#pragma once

#include <cassert>
#include <cstdint>
#include <vector>

#include "grtx/frontend/accel/node_image.h"
#include "grtx/frontend/gaussian/canonical_hit.h"
#include "grtx/frontend/gaussian/world_triangle.h"
#include "grtx/frontend/tracer/k_buffer.h"

namespace grtx::frontend {

/// A node that the ray may visit: a child whose box it hit, or a root. `link` is 0 until the node itself is tested.
struct ReachedNode {
  float enter = 0.0f;
  float exit = 0.0f;
  std::uint32_t node = 0;    ///< units; in the head of a list: its length
  std::uint32_t packed = 0;  ///< kind (3 bits), slot (3 bits), link

  static constexpr std::uint32_t kMaxLink = (1u << 26) - 1;
  ReachedNode() = default;
  ReachedNode(float enter_t, float exit_t, std::uint32_t units, NodeKind kind, unsigned slot)
      : enter(enter_t), exit(exit_t), node(units), packed(static_cast<std::uint32_t>(kind) | slot << 3) {}
  static NodeKind kind_of(std::uint32_t packed) { return static_cast<NodeKind>(packed & 7u); }
  static std::uint32_t link_of(std::uint32_t packed) { return packed >> 6; }
  unsigned slot() const { return packed >> 3 & 7u; }
  std::uint32_t link() const { return link_of(packed); }
  void set_link(std::uint32_t link) {
    assert(link <= kMaxLink);
    packed = (packed & 63u) | link << 6;
  }
};
static_assert(sizeof(ReachedNode) == 16);

/// An instance leaf that the ray has entered.
struct EnteredInstance {
  std::uint32_t gaussian = 0;
  std::uint32_t root = 0;  ///< BLAS root as this instance's ray reaches it, index of a ReachedNode
  UnitRay unit;
  SlabRay slabs;
  Hit hit;  ///< valid once hit_known
  bool hit_known = false;
  std::uint32_t decision = 0;  ///< without a walk of the BLAS: the link that its leaf would have; 0: not known yet
  ShearedRay sheared;          ///< for tests against stored vertices
};

/// One per tracer, cleared for each ray. Indices stay valid while it grows, references do not.
class WalkMemory {
 public:
  /// Links of leaves: the test's result, or kFirstHit + the index of a hit.
  static constexpr std::uint32_t kMissed = 1, kInside = 2, kFirstHit = 3;

  void clear() {
    used_ = 0;
    instances_.clear();
    hits_.clear();
  }
  std::uint32_t add(const ReachedNode& node) {
    const std::uint32_t index = reserve(1);
    nodes_[index] = node;
    return index;
  }
  /// Reserves `count` (at most nine) consecutive nodes; returns the first index.
  std::uint32_t reserve(std::uint32_t count) {
    if (used_ + 9 > nodes_.size()) grow();
    const std::uint32_t first = used_;
    used_ += count;
    return first;
  }
  ReachedNode& operator[](std::uint32_t index) { return nodes_[index]; }

  std::uint32_t add_instance() {
    instances_.emplace_back();
    return static_cast<std::uint32_t>(instances_.size());
  }
  EnteredInstance& instance(std::uint32_t link) { return instances_[link - 1]; }

  std::uint32_t add_hit(const KEntry& hit) {
    hits_.push_back(hit);
    return kFirstHit + static_cast<std::uint32_t>(hits_.size() - 1);
  }
  const KEntry& hit(std::uint32_t link) const { return hits_[link - kFirstHit]; }

 private:
  /// Separate, so that reserve() is small enough to be inlined.
  [[gnu::noinline]] void grow() { nodes_.resize(2 * nodes_.size()); }

  std::vector<ReachedNode> nodes_ = std::vector<ReachedNode>(1024);
  std::uint32_t used_ = 0;
  std::vector<EnteredInstance> instances_;
  std::vector<KEntry> hits_;
};

}  // namespace grtx::frontend
