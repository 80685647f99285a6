// SPDX-License-Identifier: Apache-2.0
// The lists of a ray as the page of `grtx ray` gets them: as a round begins, and what each event changes in them. The
// page's script (web/events.js) applies the changes and knows no rule.
//
// Numbers are varints, times 32-bit floats, which are only there if the scene is given (NaN: not known). A place on the
// stack counts from its top.
//   k-buffer, eviction buffer: count, then of each hit: owner + 1 (its instance leaf, or its primitive leaf where there
//     is none; 0: not known), object + 1 (leaf of the scene TLAS), Gaussian + 1 (0: not known), t
//   source list, stack: count, then of each entry: node, instance + 1, object + 1, t
//   t_max
//   started (with several nodes under way only): count, then the place on the stack of each node that is under way now
//   the events, in the order in which the ray came to them:
//     a byte: kind in bits 0-2, detail or outcome in 3-5, checkpointed in 6, a new t_max follows in 7
//     what it is about. replay_*: place in the source list; visit_instance with detail 1: node; others: place on the
//       stack of the entry that leaves it
//     what it pushes, where that entry was, else on top. visit_internal: a byte that counts the children, a byte for
//     the
//       slot of each, the topmost first, a byte with the mask of those checkpointed, t of each pushed, t of each
//       checkpointed; visit_instance with detail 0: the root below
//     visit_leaf, unless it missed: t; if the hit replaces another, the place of that in the k-buffer + 2 (0: there is
//       none; 1: the trace does not say which, and no hit of the k-buffer is known any more); if the hit enters, its
//       place, with Header::opacity_bound the number of entries at the end of the k-buffer that then leave, and in an
//       unsorted buffer the number of entries that it moved
//     the new t_max
//     started
#pragma once

#include <bit>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "grtx/traces/byte_stream.h"

namespace grtx::report {

inline constexpr float kUnknownTime = std::numeric_limits<float>::quiet_NaN();

/// A node on the stack or in a checkpoint list. instance, object: node numbers + 1, 0 for none.
struct NodeEntry {
  std::uint32_t node = 0, instance = 0, object = 0;
  float t = kUnknownTime;
};

/// A hit in the k-buffer or the eviction buffer. owner, object, gaussian: numbers + 1, 0 if unknown or none.
struct HitEntry {
  std::uint32_t owner = 0, object = 0, gaussian = 0;
  float t = kUnknownTime;
  std::uint32_t made = 0;  ///< serial number of the hit in the ray

  friend bool operator<(const HitEntry& a, const HitEntry& b) {
    return a.t < b.t || (a.t == b.t && a.gaussian < b.gaussian);
  }
};

class PackedRound {
 public:
  explicit PackedRound(bool has_times) : has_times_(has_times) {}

  void byte(unsigned value) { bytes_.push_back(static_cast<std::uint8_t>(value)); }
  void number(std::uint64_t value) { traces::put_varint(bytes_, value); }
  void time(float t) {
    if (has_times_) traces::put_u32(bytes_, std::bit_cast<std::uint32_t>(t));
  }
  void list(const std::vector<HitEntry>& hits) {
    number(hits.size());
    for (const HitEntry& hit : hits) {
      number(hit.owner);
      number(hit.object);
      number(hit.gaussian);
      time(hit.t);
    }
  }
  void list(const std::vector<NodeEntry>& entries) {
    number(entries.size());
    for (const NodeEntry& entry : entries) {
      number(entry.node);
      number(entry.instance);
      number(entry.object);
      time(entry.t);
    }
  }
  std::vector<std::uint8_t> take() { return std::exchange(bytes_, {}); }

 private:
  bool has_times_;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace grtx::report
