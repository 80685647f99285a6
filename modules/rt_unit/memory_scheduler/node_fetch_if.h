// SPDX-License-Identifier: Apache-2.0
// Interfaces of the memory scheduler: the RT scheduler requests node visits, the node dispatch receives fetched nodes.
#pragma once

#include <cstdint>
#include <systemc>

#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/messages/node_fetch_messages.h"
#include "grtx/modules/messages/read_at_once_if.h"
#include "grtx/modules/rt_unit/decide/node_traffic.h"
#include "grtx/modules/rt_unit/decide/node_visit.h"
#include "grtx/modules/rt_unit/part/rt_part.h"
#include "grtx/modules/rt_unit/warp_buffer/warp_buffer_if.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

struct MemorySchedulerCounters;

/// The RT scheduler's view of the memory scheduler.
class node_fetch_if : public virtual sc_core::sc_interface {
 public:
  /// The bytes that a node visit reads.
  virtual const NodeTraffic& traffic() const = 0;
  /// Whether the visits of a full warp are guaranteed to fit.
  virtual bool has_room() const = 0;
  /// Starts the visits of one warp in one cycle. Requires has_room().
  virtual void begin_warp(Cycle now, unsigned entry) = 0;
  /// Lane `id` of that warp visits the node at `address` (bytes). header: also read the BLAS header. When the node has
  /// arrived, fetched_node_if::fetched() is called.
  virtual void visit(LaneId id, traces::NodeKind kind, std::uint64_t address, bool header) = 0;
  /// Counts a further lane's visit of a node that is fetched once for all of them.
  virtual void count_visit(const NodeVisit& /*node*/) {}
};

/// Receives fetched nodes; implemented by the node dispatch.
class fetched_node_if : public virtual sc_core::sc_interface {
 public:
  /// All sectors of the node that `lanes` of the warp in `entry` wait for have arrived.
  virtual void fetched(Cycle now, unsigned entry, LaneMask lanes, traces::NodeKind kind) = 0;
};

/// Base class of memory schedulers. Either it is a client of the L1 (request, response), or the SIMT core reads the
/// nodes for it (batch, batch_done).
class NodeFetchModule : public RtMemoryPart, public node_fetch_if {
 public:
  sc_core::sc_port<warp_buffer_if> warp_buffer{"warp_buffer"};
  sc_core::sc_port<fetched_node_if> fetched_node{"fetched_node"};
  OptionalLinkOut<MemoryRequest> request{"request"};
  OptionalLinkIn<MemoryResponse> response{"response"};
  OptionalLinkOut<NodeFetchBatch> batch{"batch"};
  OptionalLinkIn<NodeFetchDone> batch_done{"batch_done"};
  /// The L1 itself, where rt.memory.l1_hit_latency asks it in the cycle of the request.
  OptionalReadAtOnce l1_reads{"l1_reads"};

  /// Counters since the start of the launch.
  virtual MemorySchedulerCounters counters() const = 0;

 protected:
  using RtMemoryPart::RtMemoryPart;
};

}  // namespace grtx::modules
