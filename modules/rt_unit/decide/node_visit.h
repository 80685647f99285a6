// SPDX-License-Identifier: Apache-2.0
// The node that a trace event visits, and the sectors to read for it. Every conversion of visits to memory requests
// uses this.
#pragma once

#include <cstdint>
#include <optional>

#include "grtx/modules/messages/coalescer.h"
#include "grtx/modules/rt_unit/decide/node_traffic.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

struct NodeVisit {
  traces::NodeKind kind = traces::NodeKind::internal;
  std::uint64_t address = 0;  ///< bytes
  bool header = false;        ///< instance leaf: also read the header of the tree below
};

/// The kind of a visited leaf. The child byte of its parent says whether it is wide, so the hardware knows that before
/// it fetches the leaf; it keeps the kind with the node's address.
inline traces::NodeKind of_width(const traces::Event& event, traces::NodeKind leaf) {
  return event.wide() ? traces::wide_kind(leaf) : leaf;
}

/// Returns nullopt if the event visits no node, or one that does not exist.
inline std::optional<NodeVisit> node_visit(const traces::Event& event, const traces::RayGroup& group,
                                           const NodeTraffic& traffic) {
  switch (event.kind()) {
    case traces::EventKind::visit_internal:
      if (event.node >= group.nodes.size()) return std::nullopt;
      return NodeVisit{traces::NodeKind::internal, traffic.address(group.nodes[event.node].address)};
    case traces::EventKind::visit_instance:
      if (!traffic.two_level()) return std::nullopt;
      // detail 0 enters the tree below at its root; detail 1 continues at a replayed node inside it.
      return NodeVisit{of_width(event, traces::NodeKind::instance), traffic.address(event.node),
                       event.detail == 0 && traffic.header_read()};
    case traces::EventKind::visit_leaf:
      return NodeVisit{of_width(event, traffic.leaf_kind()), traffic.address(event.node)};
    default:
      return std::nullopt;
  }
}

/// The rule that is broken if node_visit() finds no node for a visit.
inline const char* rule_of_missing_node(const traces::Event& event) {
  return event.kind() == traces::EventKind::visit_internal ? "visits an internal node that the group does not define"
                                                           : "visits an instance leaf of a monolithic structure";
}

/// Whether the ray is transformed at procedural leaves: in a monolithic BVH they hold the matrix to the unit sphere;
/// with a shared BLAS the instance leaf does.
inline bool transforms_leaves(const traces::Header& header) {
  return !header.two_level && traces::has_procedural_leaves(header.accel) && !traces::has_box_leaves(header.accel);
}

inline bool is_primitive(traces::NodeKind kind) {
  return kind == traces::NodeKind::triangle || traces::without_width(kind) == traces::NodeKind::procedural;
}

/// The part of a visit that one fetch reads: all of it, or one of two reads of which the second waits for the first.
enum class NodePart : std::uint8_t { whole, first, second };

/// Cycles from the first read of the visit to the second: a leaf behind its descriptor, a header behind its instance
/// leaf. 0: one fetch reads all.
inline unsigned wait_of(const NodeVisit& visit, const NodeTraffic& traffic) {
  if (visit.header) return traffic.header_wait();
  return is_primitive(visit.kind) ? traffic.descriptor_wait() : 0;
}

/// The sectors of a visit, in this order: a leaf's descriptor (if it is a separate request), the node, the header.
class NodeSectors {
 public:
  NodeSectors(const NodeVisit& visit, const NodeTraffic& traffic, NodePart part = NodePart::whole)
      : body_(traffic.run(visit.kind, visit.address)),
        lead_(traffic.descriptor_read() && is_primitive(visit.kind) ? 1 : 0),
        tail_(visit.header ? traffic.header_sectors() : 0),
        header_(visit.header ? traffic.header_below(visit.address) : 0),
        header_region_(traffic.region(traces::NodeKind::internal, header_)) {
    if (part == NodePart::whole) return;
    const bool first = part == NodePart::first;
    (first ? tail_ : lead_) = 0;
    if (visit.header != first) body_.sectors = 0;  // the descriptor alone, or the header alone
  }

  /// Region of the fetch: that of the node itself, or of a header that is fetched alone.
  Region region() const { return body_.sectors + lead_ > 0 ? body_.region : header_region_; }
  /// Byte address of the first sector; the node's own, or that of a header that is fetched alone.
  std::uint64_t address() const { return body_.sectors + lead_ > 0 ? body_.address : header_; }
  unsigned count() const { return lead_ + body_.sectors + tail_; }
  SectorAccess at(unsigned index) const {
    const unsigned before = lead_ + body_.sectors;
    if (index >= before) return {header_ + kSectorBytes * (index - before), header_region_};
    return {body_.address + (index < lead_ ? 0 : kSectorBytes * (index - lead_)), body_.region};
  }

 private:
  SectorRun body_;
  unsigned lead_, tail_;
  std::uint64_t header_;
  Region header_region_;
};

}  // namespace grtx::modules
