// The node that an event of a trace visits, and the sectors that are read for it: the one place where a visit becomes
// memory requests.
#pragma once

#include <cstdint>
#include <optional>

#include "grtx/modules/messages/coalescer.h"
#include "grtx/modules/rt_unit/node_traffic.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

struct NodeVisit {
  traces::NodeKind kind = traces::NodeKind::internal;
  std::uint64_t address = 0;  ///< bytes
  bool header = false;        ///< the BLAS header is read as well
};

/// Nothing: the event visits no node, or one that is not there.
inline std::optional<NodeVisit> node_visit(const traces::Event& event, const traces::RayGroup& group,
                                           const NodeTraffic& traffic) {
  switch (event.kind()) {
    case traces::EventKind::visit_internal:
      if (event.node >= group.nodes.size()) return std::nullopt;
      return NodeVisit{traces::NodeKind::internal, std::uint64_t{group.nodes[event.node].address} * traces::kNodeUnit};
    case traces::EventKind::visit_instance:
      if (!traffic.two_level()) return std::nullopt;
      // detail 0 enters the BLAS at its root; detail 1 goes on at a node of it that has been replayed.
      return NodeVisit{traces::NodeKind::instance, std::uint64_t{event.node} * traces::kNodeUnit,
                       event.detail == 0 && traffic.header_read()};
    case traces::EventKind::visit_leaf:
      return NodeVisit{traffic.leaf_kind(), std::uint64_t{event.node} * traces::kNodeUnit};
    default:
      return std::nullopt;
  }
}

/// The rule that a visit breaks whose node is not there.
inline const char* rule_of_missing_node(const traces::Event& event) {
  return event.kind() == traces::EventKind::visit_internal ? "visits an internal node that the group does not define"
                                                           : "visits an instance leaf of a monolithic structure";
}

/// Sectors that follow each other in memory.
struct SectorRun {
  std::uint64_t address = 0;
  unsigned sectors = 0;
  Region region{};
  bool again = false;  ///< the next run reads them too
};

/// What a visit reads, in this order: a leaf's descriptor (if that is a request of its own), the node, the BLAS header.
/// Procedural leaves of a monolithic BVH hold the matrix to the unit sphere; of a shared BLAS the instance leaf does.
inline bool transforms_leaves(const traces::Header& header) {
  return !header.two_level && traces::has_procedural_leaves(header.accel);
}

class NodeSectors {
 public:
  NodeSectors(const NodeVisit& visit, const NodeTraffic& traffic)
      : visit_(visit),
        region_(traffic.region(visit.kind, visit.address)),
        lead_(traffic.descriptor_read() && is_primitive(visit.kind) ? 1 : 0),
        body_(traffic.sectors(visit.kind)),
        header_(traffic.blas_header()) {}

  Region region() const { return region_; }  ///< of the node
  unsigned count() const { return lead_ + body_ + tail(); }
  SectorAccess at(unsigned index) const {
    if (index >= lead_ + body_) return {header_ + kSectorBytes * (index - lead_ - body_), Region::blas};
    return {visit_.address + (index < lead_ ? 0 : kSectorBytes * (index - lead_)), region_};
  }
  /// f(run, whether it is the last).
  template <typename F>
  void for_each_run(F&& f) const {
    if (lead_ != 0) f(SectorRun{visit_.address, lead_, region_, true}, false);
    f(SectorRun{visit_.address, body_, region_}, !visit_.header);
    if (visit_.header) f(SectorRun{header_, tail(), Region::blas}, true);
  }

 private:
  static bool is_primitive(traces::NodeKind kind) {
    return kind == traces::NodeKind::triangle || kind == traces::NodeKind::procedural;
  }
  unsigned tail() const { return visit_.header ? static_cast<unsigned>(traces::kHeaderBytes / kSectorBytes) : 0; }

  NodeVisit visit_;
  Region region_;
  unsigned lead_, body_;
  std::uint64_t header_;
};

}  // namespace grtx::modules
