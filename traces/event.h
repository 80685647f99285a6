// SPDX-License-Identifier: Apache-2.0
// The event model: the traversal of each ray as a sequence of events, independent of timing. The hardware model replays
// nothing else. Node addresses are in units of the acceleration structure (NodeSizes::unit()).
//
// A ray's round is a list of events. The traversal stack is implied: an event that handles "the top of the stack" pops
// it first. In a round that starts at the root (replay = false) the stack initially holds the root. In a replay round
// the stack is initially empty, and entries are taken from the source checkpoint buffer whenever the stack is empty.
//
//
//   visit_internal   top of stack: internal node fetched, its child boxes tested. Children in `pushed()` are pushed
//                    (the one that Header::child_order visits first ends on top); children in `checkpoints` (box hit, t
//                    beyond t_max) are written to the destination buffer; when checkpointing is off or has overflowed
//                    they are dropped.
//   visit_instance   top of stack: TLAS leaf fetched, ray transformed. `detail` 0: the BLAS root is pushed;
//                    1: transform only, for a BLAS node taken from the checkpoint buffer (the node itself stays on
//                    top).
//   visit_leaf       top of stack: primitive fetched and tested, see LeafOutcome.
//   cull             top of stack is beyond the current t_max: popped without a fetch; `checkpoints` = 1 if written to
//                    the destination buffer, 0 if dropped. Only with Header::pop_test: else it is visited.
//   replay_take      next source entry read, within t_max: pushed. For a BLAS node a visit_instance with detail 1
//                    follows.
//   replay_forward   next source entry read, beyond t_max: not fetched; `checkpoints` = 1 if written to the
//                    destination.
//
// With Header::checkpoint_bins there are bins instead of the two buffers: each written entry goes to the bin given in
// Ray::bins, and a round may end before it has read all entries that were present when it began.
//
// Header::tracing says how a round collects hits. multi: sorted insertion into the k-buffer. single: hits are appended
// unsorted (no shifts); when the buffer is full it becomes a heap, whose largest entry is displaced by nearer hits; it
// is sorted when the round ends. list: like single, with a list instead of the buffer. closest: no any-hit shader; the
// only entry is the nearest hit (LeafOutcome::nearest).
//
// Header::any_hit says when the any-hit shaders of a round run. immediate: a visit_leaf whose outcome calls one waits
// for it. delayed: the ray appends the hit to its queue and goes on; when all rays of the warp have ended their
// traversal, the shaders take each queue in order. Outcome and shifts are those of the hit's turn. With box leaves
// every visit_leaf is queued, because only the intersection shader finds its outcome. t_max is the end of the ray in
// all rounds, so there are no culls, and `beyond` is what lies behind that end.
//
// With Header::opacity_bound a ray ends at t_j as soon as the hits found up to there let less light through than the
// threshold of early termination: t_max is t_j at most, in later rounds, too, and what lies behind is neither pushed
// nor checkpointed. Hits of the k-buffer behind it leave (Event::hidden()), and a round is preloaded up to it.
//
// Header::ahead says how many nodes of a ray were under way at once. The events are listed depth first, as above, but
// the ray did not handle them in that order: its culls and the outcomes of its hits follow from t_max and k-buffer as
// they were when it handled the event. So a hit may be displaced or rejected before the list shows the k-buffer full.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "grtx/traces/checkpoint_bins.h"
#include "grtx/traces/node_layout.h"

namespace grtx::traces {

enum class EventKind : std::uint8_t {
  visit_internal = 0,
  visit_instance = 1,
  visit_leaf = 2,
  cull = 3,
  replay_take = 4,
  replay_forward = 5
};

/// Result of a leaf's primitive test. Outcomes marked any-hit invoke the any-hit shader.
enum class LeafOutcome : std::uint8_t {
  miss = 0,       ///< not hit (or culled: back face, origin inside the proxy)
  behind = 1,     ///< hit, but t < t_min: already blended, no any-hit
  beyond = 2,     ///< hit, but t > t_max: leaf checkpointed (checkpoints = 1) or dropped
  inserted = 3,   ///< any-hit: k-buffer had room
  displaced = 4,  ///< any-hit: inserted, and the last entry dropped out (evicted when checkpointing)
  rejected = 5,   ///< any-hit: did not fit; evicted when checkpointing; t_max becomes t_hit if any_hit is immediate
  ignored = 6,    ///< any-hit: filtered (t == t_min tie already blended, or Gaussian already in the k-buffer)
  nearest = 7  ///< tracing = closest, no any-hit: the nearest hit so far, replaces the one before; t_max becomes its t
};
inline constexpr LeafOutcome kLastLeafOutcome = LeafOutcome::nearest;
constexpr bool calls_any_hit(LeafOutcome o) { return o >= LeafOutcome::inserted && o <= LeafOutcome::ignored; }

struct Event {
  std::uint32_t node = 0;   ///< visit_internal: index into RayGroup::nodes; else node address in units
  std::uint8_t detail = 0;  ///< visit_internal: mask of pushed children; visit_leaf: LeafOutcome; visit_instance: 0/1
  /// visit_internal: mask of checkpointed children; visit_leaf of a hit that enters: see hidden(); others: 0/1
  std::uint8_t checkpoints = 0;
  /// kind (3 bits) | visited leaf is wide (1 bit) | k-buffer or heap entries moved by the insertion (12 bits)
  std::uint16_t kind_shifts = 0;

  EventKind kind() const { return static_cast<EventKind>(kind_shifts & 0x7); }
  /// visit_instance, visit_leaf: the leaf is of a wide kind, as its parent's NodeDefinition says, too.
  bool wide() const { return (kind_shifts & kWide) != 0; }
  static constexpr std::uint16_t kWide = 8;
  unsigned shifts() const { return kind_shifts >> 4; }
  /// Of a hit that enters, with Header::opacity_bound: entries of the k-buffer, the hit itself among them, that lie
  /// behind the new end of the ray and leave.
  unsigned hidden() const { return has_hidden() ? checkpoints : 0; }
  /// Checkpoint entries that the event writes: mask of an internal node's children, or 0/1.
  unsigned written() const { return has_hidden() ? 0 : checkpoints; }
  LeafOutcome outcome() const { return static_cast<LeafOutcome>(detail); }
  unsigned pushed() const { return detail; }
  static constexpr std::uint16_t pack(EventKind kind, unsigned shifts = 0) {
    return static_cast<std::uint16_t>(static_cast<unsigned>(kind) | (shifts << 4));
  }
  friend bool operator==(const Event&, const Event&) = default;

 private:
  bool has_hidden() const { return kind() == EventKind::visit_leaf && calls_any_hit(outcome()); }
};
static_assert(sizeof(Event) == 8);
inline constexpr unsigned kMaxShifts = 4095;

/// An internal node that a ray group visited, and its children, which are contiguous in slot order.
struct NodeDefinition {
  std::uint32_t address = 0;                      ///< in units
  std::uint32_t child_base = 0;                   ///< address of child 0 in units
  std::array<NodeKind, kMaxWidth> child_kinds{};  ///< per slot; unused slots: internal
  std::uint8_t child_count = 0;
  friend bool operator==(const NodeDefinition&, const NodeDefinition&) = default;
};

/// A k-buffer entry that the ray generation shader processed for blending, front to back.
struct Processed {
  std::uint32_t gaussian : 31 = 0;
  std::uint32_t blended : 1 = 0;  ///< 0: not blended, because its alpha was below 1/255 or d2 > kappa2
  friend bool operator==(const Processed&, const Processed&) = default;
};
static_assert(sizeof(Processed) == 4);

/// One traceRay call of one ray.
struct Round {
  std::uint32_t event_count = 0;
  std::uint16_t preloaded = 0;        ///< entries moved from the eviction buffer into the k-buffer before tracing
  std::uint16_t k_count = 0;          ///< entries in the k-buffer when tracing ended
  std::uint16_t processed_count = 0;  ///< of those, entries processed before early ray termination
  bool replay = false;                ///< replay flag: false = started at the root
  bool overflow = false;  ///< destination buffer overflowed: its entries are dropped, the next round starts at the root
  bool terminated = false;             ///< transmittance fell below the threshold
  std::uint32_t eviction_dropped = 0;  ///< eviction buffer entries dropped at the end of an overflowed round
  BinOrder bins;                       ///< read order of a replay with Header::checkpoint_bins
  friend bool operator==(const Round&, const Round&) = default;
};

/// One ray: its rounds, and the events and processed entries of all rounds in sequence.
struct Ray {
  std::uint32_t pixel = 0;  ///< y * width + x
  std::vector<Round> rounds;
  std::vector<Event> events;
  std::vector<Processed> processed;
  std::vector<std::uint8_t> bins;  ///< bin of each written checkpoint entry; empty without Header::checkpoint_bins
  friend bool operator==(const Ray&, const Ray&) = default;
};

/// Kind of the rays of a group.
enum class RayKind : std::uint8_t { primary = 0, glass = 1, mirror = 2 };

/// The rays of one warp (as mapped by the tracer); one chunk of the file. A ray without rounds had nothing to trace.
struct RayGroup {
  std::uint32_t index = 0;  ///< position in the file
  std::uint32_t frame = 0;  ///< frame of a sequence; follows from the header, not stored in the group
  RayKind kind = RayKind::primary;
  std::vector<NodeDefinition> nodes;  ///< distinct internal nodes visited, ascending address
  std::vector<Ray> rays;              ///< lane order; at most the header's warp_size
  friend bool operator==(const RayGroup&, const RayGroup&) = default;
};

}  // namespace grtx::traces
