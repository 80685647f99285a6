// What one node visit reads from memory: which bytes, and under which region the caches count them.
#pragma once

#include <cstdint>

#include "grtx/modules/kernel/parameter.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/traces/header.h"
#include "grtx/traces/node_layout.h"

namespace grtx::modules {

struct NodeTrafficConfig {
  unsigned instance_leaf_bytes = 128;  ///< 64 is the half that suffices
  bool blas_header_read = true;        ///< with a visit_instance whose detail is 0
  bool leaf_descriptor_read = false;
  void parameters(ParameterList& list) {
    list.add("instance_leaf_bytes", instance_leaf_bytes, {64, 128}, "B", "bytes read of an instance leaf, 64 or 128",
             from_public("Vulkan-Sim reads all 128"));
    list.add("blas_header_read", blas_header_read, "entering a BLAS also reads its 64 B header",
             from_public("Vulkan-Sim"));
    list.add("leaf_descriptor_read", leaf_descriptor_read, "a primitive leaf's 8 B descriptor is a request of its own",
             assumed("Vulkan-Sim does; off because it is part of the leaf"));
  }
};

class NodeTraffic {
 public:
  NodeTraffic(const traces::Header& header, const NodeTrafficConfig& config)
      : config_(config), bvh_width_(header.bvh_width), two_level_(header.two_level), blas_base_(header.blas_base) {
    procedural_ = traces::has_procedural_leaves(header.accel);
  }

  /// Kind of every primitive leaf of the trace: one structure holds one kind only.
  traces::NodeKind leaf_kind() const { return procedural_ ? traces::NodeKind::procedural : traces::NodeKind::triangle; }
  bool two_level() const { return two_level_; }
  bool header_read() const { return config_.blas_header_read; }
  bool descriptor_read() const { return config_.leaf_descriptor_read; }
  std::uint64_t blas_header() const { return blas_base_; }
  /// Bytes a node occupies in the image: the step from one child to the next.
  std::uint64_t stored_bytes(traces::NodeKind kind) const { return traces::node_bytes(kind, bvh_width_); }
  /// Sectors read for the node itself.
  unsigned sectors(traces::NodeKind kind) const {
    const std::uint64_t bytes =
        kind == traces::NodeKind::instance ? config_.instance_leaf_bytes : traces::node_bytes(kind, bvh_width_);
    return static_cast<unsigned>(bytes / kSectorBytes);
  }
  Region region(traces::NodeKind kind, std::uint64_t address) const {
    if (kind == traces::NodeKind::instance) return Region::instance;
    if (two_level_ && address >= blas_base_) return Region::blas;
    return kind == traces::NodeKind::internal ? Region::tlas : Region::leaf;
  }

 private:
  NodeTrafficConfig config_;
  unsigned bvh_width_;
  bool two_level_;
  std::uint64_t blas_base_;
  bool procedural_;
};

}  // namespace grtx::modules
