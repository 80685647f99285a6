// SPDX-License-Identifier: Apache-2.0
// Memory reads of a node visit: which bytes, and the region under which the caches count them.
#pragma once

#include <cstdint>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"
#include "grtx/traces/instance_levels.h"
#include "grtx/traces/node_layout.h"

namespace grtx::modules {

struct NodeTrafficConfig {
  unsigned instance_leaf_bytes = 128;  ///< 64: only the half that is needed, as other layouts do
  bool blas_header_read = true;        ///< for a visit_instance with detail 0
  bool leaf_descriptor_read = false;
  unsigned descriptor_wait = 0;  ///< 0: descriptor and leaf are one fetch
  unsigned header_wait = 0;      ///< 0: instance leaf and header are one fetch
  void parameters(ParameterList& list) {
    list.add("instance_leaf_bytes", instance_leaf_bytes, {64, 128}, "B", "bytes read of an instance leaf, 64 or 128",
             from_public("Vulkan-Sim reads all 128; of other layouts always the part that suffices"));
    list.add("blas_header_read", blas_header_read, "entering a BLAS, or an object's TLAS, also reads its 64 B header",
             from_public("Vulkan-Sim; never in other layouts"));
    list.add(
        "leaf_descriptor_read", leaf_descriptor_read, "a primitive leaf's 8 B descriptor is a request of its own",
        assumed("off because it is part of the leaf; Vulkan-Sim reads it, and the leaf after it (descriptor_wait)"));
    list.add("descriptor_wait", descriptor_wait, {0, kMaxLatency}, "cycles",
             "from a leaf's descriptor to the request of the leaf, a fetch of its own; 0: both are one fetch",
             assumed("0, as the descriptor lies in the leaf; Vulkan-Sim: 4"));
    list.add(
        "header_wait", header_wait, {0, kMaxLatency}, "cycles",
        "from an instance leaf to the request of the header below, a fetch that lanes share; 0: both are one fetch",
        assumed("0, as the header's address is known with the leaf's; Vulkan-Sim: 8"));
    list.rule(
        "descriptor_wait", [this] { return descriptor_wait == 0 || leaf_descriptor_read; },
        "needs rt.memory.leaf_descriptor_read");
    list.rule(
        "header_wait", [this] { return header_wait == 0 || blas_header_read; }, "needs rt.memory.blas_header_read");
    list.rule(
        "instance_leaf_bytes", [this] { return instance_leaf_bytes == 64 || instance_leaf_bytes == 128; },
        "must be 64 or 128");
  }
};

/// Slot of the child at `address` (in units); kMaxWidth if there is none. units(kind): size of a node in the image.
template <typename Units>
unsigned child_slot(const traces::NodeDefinition& node, std::uint32_t address, Units&& units) {
  std::uint32_t child = node.child_base;  // children are contiguous in slot order
  for (unsigned i = 0; i < node.child_count; ++i) {
    if (child == address) return i;
    child += units(node.child_kinds[i]);
  }
  return traces::kMaxWidth;
}

/// Consecutive sectors.
struct SectorRun {
  std::uint64_t address = 0;
  unsigned sectors = 0;
  Region region{};
};

class NodeTraffic {
 public:
  NodeTraffic(const traces::Header& header, const NodeTrafficConfig& config)
      : config_(config),
        sizes_(header.node_sizes()),
        two_level_(header.two_level),
        blas_base_(header.blas_base),
        objects_base_(header.objects_base()),
        levels_(header),
        procedural_(traces::has_procedural_leaves(header.accel)) {}

  /// Kind of all primitive leaves of the trace; an acceleration structure has only one.
  traces::NodeKind leaf_kind() const { return procedural_ ? traces::NodeKind::procedural : traces::NodeKind::triangle; }
  bool two_level() const { return two_level_; }
  bool header_read() const { return config_.blas_header_read && !sizes_.short_instances(); }
  bool descriptor_read() const { return config_.leaf_descriptor_read; }
  unsigned descriptor_wait() const { return config_.descriptor_wait; }
  unsigned header_wait() const { return config_.header_wait; }
  std::uint64_t blas_header() const { return blas_base_; }
  const traces::InstanceLevels& levels() const { return levels_; }
  /// Byte address of the header of the tree below the instance leaf at byte address `leaf`, which must exist.
  std::uint64_t header_below(std::uint64_t leaf) const {
    if (leaf >= objects_base_) return blas_base_;
    return levels_.object_root(levels_.root_below(static_cast<std::uint32_t>(leaf / sizes_.unit()))) * sizes_.unit() -
           sizes_.header_bytes();
  }
  /// Converts a node address in units, as in events, to bytes.
  std::uint64_t address(std::uint32_t units) const { return units * sizes_.unit(); }
  std::uint32_t units(std::uint64_t address) const { return static_cast<std::uint32_t>(address / sizes_.unit()); }
  /// Size of a node in the image, in units: the distance from one child to the next.
  unsigned stored_units(traces::NodeKind kind) const { return sizes_.units(kind); }
  /// The sectors read of the node itself.
  SectorRun run(traces::NodeKind kind, std::uint64_t address) const {
    const std::uint64_t bytes = kind == traces::NodeKind::instance && !sizes_.short_instances()
                                    ? config_.instance_leaf_bytes
                                    : sizes_.read_bytes(kind);
    const std::uint64_t first = address / kSectorBytes, end = (address + bytes + kSectorBytes - 1) / kSectorBytes;
    return {first * kSectorBytes, static_cast<unsigned>(end - first), region(kind, address)};
  }
  unsigned header_sectors() const { return static_cast<unsigned>(sizes_.header_bytes() / kSectorBytes); }
  /// Intersection tests per visit of a primitive leaf.
  unsigned leaf_tests() const { return procedural_ ? 1 : sizes_.triangles(); }
  Region region(traces::NodeKind kind, std::uint64_t address) const {
    if (traces::without_width(kind) == traces::NodeKind::instance) return Region::instance;
    if (two_level_ && address >= blas_base_) return Region::blas;
    return kind == traces::NodeKind::internal ? Region::tlas : Region::leaf;
  }

 private:
  NodeTrafficConfig config_;
  traces::NodeSizes sizes_;
  bool two_level_;
  std::uint64_t blas_base_;
  std::uint64_t objects_base_;  ///< 0: no scene TLAS
  traces::InstanceLevels levels_;
  bool procedural_;
};

}  // namespace grtx::modules
