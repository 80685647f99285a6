// SPDX-License-Identifier: Apache-2.0
// The rules of a round: what becomes of a hit, when t_max moves, when a ray goes on, and from where. Tracer,
// trace-check and the page of a ray ask here; lists that follow these rules are in round_hits.h. Paper, Listing 1;
// docs/model/tracer.md, "Rounds".
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "grtx/traces/event.h"
#include "grtx/traces/header.h"
#include "grtx/traces/modes.h"

namespace grtx::traces {

/// Whether a hit of this outcome enters the k-buffer.
constexpr bool enters(LeafOutcome o) {
  return o == LeafOutcome::inserted || o == LeafOutcome::displaced || o == LeafOutcome::nearest;
}
/// Whether it takes the place of the k-buffer's last entry.
constexpr bool replaces(LeafOutcome o) { return o == LeafOutcome::displaced || o == LeafOutcome::nearest; }
/// Whether the round loses a hit: the entry that is replaced, or the hit itself if it does not enter. With
/// checkpointing the eviction buffer keeps it for later rounds.
constexpr bool evicts(LeafOutcome o) { return o == LeafOutcome::displaced || o == LeafOutcome::rejected; }
/// Whether its entry may move others: Event::shifts().
constexpr bool may_shift(LeafOutcome o) { return o == LeafOutcome::inserted || o == LeafOutcome::displaced; }

class RoundRules {
 public:
  /// k_moves_t_max: t_max follows the last entry of a full k-buffer, not the hit that was rejected.
  RoundRules(Tracing tracing, AnyHit any_hit, unsigned k, bool checkpoint, bool k_moves_t_max)
      : tracing_(tracing), k_(k), checkpoint_(checkpoint), delayed_(any_hit == AnyHit::delayed), kth_(k_moves_t_max) {}
  /// For readers of a trace, which does not say how t_max moves: not for t_max().
  explicit RoundRules(const Header& header)
      : RoundRules(header.tracing, header.any_hit, header.k, header.checkpoint, false) {}

  unsigned k() const { return k_; }
  /// Whether the k-buffer is sorted at all times, not only when the round ends.
  bool sorted() const { return !collects_unsorted(tracing_); }
  bool keeps_evictions() const { return checkpoint_; }

  // A hit.

  /// Of a new hit up to t_max. full: the k-buffer is; nearer: the hit then precedes its last entry.
  LeafOutcome outcome(bool full, bool nearer) const {
    if (tracing_ == Tracing::closest) return !full || nearer ? LeafOutcome::nearest : LeafOutcome::beyond;
    if (!full) return LeafOutcome::inserted;
    return nearer ? LeafOutcome::displaced : LeafOutcome::rejected;
  }
  /// t_max after a hit at t. last: t of the k-buffer's last entry if it is full now, else infinity. The smaller one
  /// holds: a hit of an instance that is finished (BelowInstance) may lie beyond t_max. Delayed shaders take hits when
  /// the traversal is over.
  float t_max(LeafOutcome outcome, float t_max, float t, float last) const {
    if (delayed_) return t_max;
    if (kth_) return std::min(t_max, last);
    return outcome == LeafOutcome::rejected || outcome == LeafOutcome::nearest ? std::min(t_max, t) : t_max;
  }
  /// The rule that a recorded outcome breaks; null: none. held: entries of the k-buffer before the hit. in_order:
  /// events stand as the ray came to them, else `held` only tells whether there is room.
  const char* broken_by(LeafOutcome outcome, unsigned shifts, std::uint64_t held, bool in_order) const;

  /// Entries of the k-buffer after a hit of this outcome.
  static std::uint64_t held_after(LeafOutcome outcome, std::uint64_t held) {
    if (outcome == LeafOutcome::nearest) return 1;
    return outcome == LeafOutcome::inserted ? held + 1 : held;
  }

  // Rounds.

  /// Entries that the next round moves from an eviction buffer of this size into its k-buffer; fewer if the ray ends
  /// among them (Header::opacity_bound).
  std::uint64_t preloaded(std::uint64_t evictions) const { return std::min<std::uint64_t>(k_, evictions); }
  /// Whether the ray goes on after this round: it may have more hits, and can see them.
  bool goes_on(const Round& round) const { return !round.terminated && round.k_count == k_; }
  /// Whether the round after this one starts from checkpoints; else it starts at the root.
  bool replays_after(const Round& round) const { return checkpoint_ && !round.overflow; }

 private:
  Tracing tracing_;
  unsigned k_;
  bool checkpoint_;
  bool delayed_;
  bool kth_;
};

inline const char* RoundRules::broken_by(LeafOutcome outcome, unsigned shifts, std::uint64_t held,
                                         bool in_order) const {
  constexpr const char* kTooManyShifts = "an insertion cannot shift more entries than there are";
  if (shifts != 0 && !may_shift(outcome)) return "only an insertion shifts";
  if (tracing_ == Tracing::closest) {
    return calls_any_hit(outcome) ? "closest-hit tracing calls no any-hit shader" : nullptr;
  }
  if (outcome == LeafOutcome::nearest) return "only closest-hit tracing commits nearest hits";
  if (!enters(outcome) && !evicts(outcome)) return nullptr;
  if (!sorted()) {
    if (outcome == LeafOutcome::inserted && shifts != 0 && held + 1 != k_) {
      return "single-round tracing appends without moving entries, unless the buffer is then full";
    }
    if (shifts >= static_cast<unsigned>(std::bit_width(k_)) && outcome == LeafOutcome::displaced) {
      return "a heap of k entries moves at most log2(k) of them";
    }
  }
  // A trace does not say which of two hits is nearer; one of the answers must give the recorded outcome.
  const bool full = held == k_;
  if (outcome != this->outcome(full, true) && outcome != this->outcome(full, false)) {
    if (outcome == LeafOutcome::inserted) return "an insertion needs room in the k-buffer";
    if (in_order) return "only a full k-buffer displaces or rejects";
  }
  const bool displaces = outcome == LeafOutcome::displaced;
  const std::uint64_t movable = displaces || !in_order ? std::uint64_t{k_} - 1 : held;
  return shifts > movable ? kTooManyShifts : nullptr;
}

}  // namespace grtx::traces
