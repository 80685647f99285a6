// Between the RT scheduler, which sends lanes to their nodes, the memory scheduler, which fetches those, and the node
// dispatch, which takes what has been fetched.
#pragma once

#include <cstdint>
#include <systemc>

#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/messages/node_fetch_messages.h"
#include "grtx/modules/rt_unit/decide/node_traffic.h"
#include "grtx/modules/rt_unit/decide/node_visit.h"
#include "grtx/modules/rt_unit/rt_part.h"
#include "grtx/modules/rt_unit/warp_buffer_if.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

struct MemorySchedulerCounters;

/// The RT scheduler's view of the memory scheduler.
class node_fetch_if : public virtual sc_core::sc_interface {
 public:
  /// What a node visit reads.
  virtual const NodeTraffic& traffic() const = 0;
  /// Whether any warp's visits are sure to fit.
  virtual bool has_room() const = 0;
  /// Starts the visits of one warp in one cycle. Only when has_room().
  virtual void begin_warp(Cycle now, unsigned entry) = 0;
  /// Lane `id` of that warp visits the node at `address` (bytes). header: the BLAS header is read as well. The node's
  /// arrival is told to fetched_node_if.
  virtual void visit(LaneId id, traces::NodeKind kind, std::uint64_t address, bool header) = 0;

  // Functional entries (RtMemoryPart::has_touch()):
  /// The sectors of a node that is visited without time meet the caches in cycle `at`.
  virtual void touch(const NodeVisit& /*node*/, Cycle /*at*/) {}
  /// A visit without time is counted.
  virtual void count_visit(const NodeVisit& /*node*/) {}
  /// Cycles until a fetch of the node by the warp in `entry` that is under way is likely to be back; 0: there is none.
  virtual Cycle remaining(unsigned /*entry*/, const NodeVisit& /*node*/, Cycle /*now*/) const { return 0; }
};

/// Where fetched nodes go.
class fetched_node_if : public virtual sc_core::sc_interface {
 public:
  /// The node that `lanes` of the warp in `entry` wait for is there, all sectors of it.
  virtual void fetched(Cycle now, unsigned entry, LaneMask lanes, traces::NodeKind kind) = 0;
};

/// A memory scheduler. Either it is a client of the L1, or the SIMT core reads the nodes for it (then the other two
/// ports are bound).
class NodeFetchModule : public RtMemoryPart, public node_fetch_if {
 public:
  sc_core::sc_port<warp_buffer_if> warp_buffer{"warp_buffer"};
  sc_core::sc_port<fetched_node_if> fetched_node{"fetched_node"};
  OptionalLinkOut<MemoryRequest> request{"request"};
  OptionalLinkIn<MemoryResponse> response{"response"};
  OptionalLinkOut<NodeFetchBatch> batch{"batch"};
  OptionalLinkIn<NodeFetchDone> batch_done{"batch_done"};

  /// What it has counted since the launch began.
  virtual MemorySchedulerCounters counters() const = 0;

 protected:
  using RtMemoryPart::RtMemoryPart;
};

}  // namespace grtx::modules
