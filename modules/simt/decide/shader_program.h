// SPDX-License-Identifier: Apache-2.0
// Cost of the two shaders of the paper's Listing 1: instructions and memory sectors of each phase of a warp. Free of
// SystemC; every decision (which hit is inserted, evicted, blended) comes from the trace.
// SIMT: lanes run in lock step, so a loop costs the iterations of its longest lane.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/coalescer.h"
#include "grtx/modules/messages/hit_heap.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/messages/node_fetch_messages.h"
#include "grtx/modules/messages/traffic_charging.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/simt/decide/shader_costs.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::modules {

/// A phase loads, then computes, then stores. Sectors are in issue order, one warp memory instruction after another.
struct ShaderPhase {
  PhaseKind kind = PhaseKind::prologue;
  std::uint64_t instructions = 0;
  std::vector<SectorAccess> loads;
  std::vector<SectorAccess> stores;
  Cycle delay = 0;  ///< cycles until the phase has what is not loaded: the heap's entries in order
  /// Ends, as indices in `loads`, of the steps of loads that wait for each other, as the iterations of a loop whose
  /// exit depends on the data read. Empty: all loads are sent at once.
  std::vector<std::uint32_t> steps;
  std::uint64_t step_instructions = 0;  ///< executed after each step but the last; included in `instructions`

  void reset(PhaseKind k, std::uint64_t n) {
    kind = k;
    instructions = n;
    loads.clear();
    stores.clear();
    delay = 0;
    steps.clear();
  }
};

/// The shader state of all resident warps of one SM. Call order for a warp: begin, prologue; then, while
/// active_lanes(): evict_move (with checkpointing), trace_call, any_hit..., sort (while sorts()), blend, sort and blend
/// again while blends_on(); finally epilogue.
class ShaderProgram {
 public:
  /// heap: if enabled, k-buffers are heaps that the any-hit unit fills. Throws Error if the header's warp size exceeds
  /// kMaxLanes, or if heaps cannot serve its kind of tracing.
  ShaderProgram(const traces::Header& header, const MemoryMap& map, const ShaderCosts& costs, unsigned sm,
                unsigned resident_warps, const HitHeap& heap = {});

  /// Starts a new warp in `slot`. The group must stay valid until after its epilogue.
  void begin(unsigned slot, const traces::RayGroup& group);
  /// Lanes whose ray has a round with the warp's current round number.
  LaneMask active_lanes(unsigned slot) const { return warps_[slot].active; }
  std::uint32_t round(unsigned slot) const { return warps_[slot].round; }
  const traces::RayGroup* group(unsigned slot) const { return warps_[slot].group; }
  /// Whether rounds start with an evict_move phase (checkpointing is on).
  bool moves_evictions() const { return checkpoint_; }

  // Each phase function fills `phase` (reusing its memory) and advances the warp's state.
  void prologue(unsigned slot, ShaderPhase& phase);
  void evict_move(unsigned slot, ShaderPhase& phase);
  void trace_call(unsigned slot, ShaderPhase& phase);
  void any_hit(const AnyHitBatch& batch, ShaderPhase& phase);
  /// Whether an any-hit unit handles the hits; a batch then holds those that fall out of their heap.
  bool has_heaps() const { return heap_.enabled; }
  /// The stores of hits that fall out of a heap. No instruction.
  void store_evicted(const AnyHitBatch& batch, ShaderPhase& phase);
  /// Whether leaves are boxes: a batch then calls the intersection shader first, and the any-hit shader for its hits.
  bool intersects() const { return boxes_; }
  void intersection(const AnyHitBatch& batch, ShaderPhase& phase);
  /// The batch for the any-hit shader: the lanes for which the intersection shader reports a hit within range.
  static AnyHitBatch hits_of(AnyHitBatch batch);
  void node_fetch(const NodeFetchBatch& batch, ShaderPhase& phase);
  /// Whether a sort phase is needed before the warp blends. Single-round tracing: a merge sort, one pass per phase.
  /// List: a scan for the next batch.
  bool sorts(unsigned slot) const;
  void sort(unsigned slot, ShaderPhase& phase);
  /// Blends the warp's round and advances to the next one. List: blends the sorted batch, and advances after the last.
  void blend(unsigned slot, ShaderPhase& phase);
  /// After blend(): whether the round has further batches (list).
  bool blends_on(unsigned slot) const { return warps_[slot].batch > 0; }
  /// The stores of a blend phase are on their way: all warps of the SM see the colours that it made.
  void publish_colours(unsigned slot);
  void epilogue(unsigned slot, ShaderPhase& phase);

  const ShaderCounters& counters() const { return counters_; }

 private:
  struct Warp {
    const traces::RayGroup* group = nullptr;
    std::uint32_t round = 0;
    LaneMask active = 0;
    unsigned sort_pass = 0;  ///< merge passes, or scans, done in this round
    unsigned batch = 0;      ///< list: batches blended in this round
    /// Entries in the k-buffer: hits that entered less those that left. Hits of a warp that walks together may come in
    /// another order than in the trace.
    std::array<std::int32_t, kMaxLanes> fill{};
    std::array<std::uint32_t, kMaxLanes> evictions{};        ///< entries in the eviction buffer
    std::array<std::uint32_t, kMaxLanes> listed{};           ///< delayed hits read in this round
    std::array<std::uint32_t, kMaxLanes> first_processed{};  ///< index in Ray::processed of the round's first entry
    std::unordered_set<std::uint32_t> making;                ///< Gaussians whose colour its blend makes
  };
  using LaneCounts = std::array<std::uint32_t, kMaxLanes>;

  const traces::Round& round_of(const Warp& warp, unsigned lane) const {
    return warp.group->rays[lane].rounds[warp.round];
  }
  /// Accesses of a batch's hits to the k-buffers of their lanes.
  struct Insertions {
    LaneCounts reads{}, writes{};   ///< entries
    LaneCounts last_read{};         ///< entry of the first read; further reads go downwards
    LaneCounts last_written{};      ///< entry of the first write; further writes go downwards
    LaneMask evicting = 0;          ///< lanes that evict an entry
    LaneMask entering = 0;          ///< lanes whose hit enters
    std::uint32_t most_hidden = 0;  ///< most entries hidden by a lane
    std::uint32_t most_shifts = 0;  ///< most entries moved by a lane
  };
  Insertions insert_hits(Warp& warp, const AnyHitBatch& batch) const;
  void any_hit_single(const AnyHitBatch& batch, ShaderPhase& phase);
  void evict(unsigned slot, LaneMask lanes, ShaderPhase& phase);
  /// Bounded: reads the records of hits that enter, for their alpha.
  void load_records(const AnyHitBatch& batch, LaneMask entering, ShaderPhase& phase);
  std::uint32_t filled(const Warp& warp, unsigned lane) const {
    return static_cast<std::uint32_t>(std::clamp(warp.fill[lane], 0, static_cast<std::int32_t>(k_)));
  }
  /// An intersection shader calls the any-hit shader itself, and has left traversal already.
  std::uint64_t any_hit_instructions(LaneMask lanes, std::uint32_t moves) const {
    return (boxes_ ? 0 : costs_.call(std::popcount(lanes))) + costs_.any_hit_fixed +
           std::uint64_t{costs_.any_hit_per_shift} * moves;
  }
  /// Instructions that a hit's alpha takes.
  std::uint64_t alpha_instructions() const {
    return costs_.blend_per_entry - std::min(costs_.blend_per_entry, costs_.blend_with_alpha);
  }
  /// The next delayed hit of each lane of the batch: a list in memory, which the RT unit has written.
  void read_list(const AnyHitBatch& batch, ShaderPhase& phase);
  /// The colours of an entry of lanes: gaussian[lane].
  void take_colours(Warp& warp, LaneMask lanes, const std::array<std::uint32_t, kMaxLanes>& gaussian, bool has_mean,
                    ShaderPhase& phase);
  void end_round(Warp& warp);
  unsigned sort_passes(std::uint32_t entries) const;
  /// Whether the round has a batch with this number.
  bool has_batch(const Warp& warp, unsigned batch) const;
  void scan_list(unsigned slot, ShaderPhase& phase);
  /// Loads or stores entry at(lane, i) for each lane of `lanes` and i = 0 .. counts[lane] - 1, in lock step. A load
  /// step of the phase ends after each iteration i with ends_step(i).
  template <typename IndexAt, typename EndsStep>
  void for_each_entry(std::uint64_t warp_slot, LaneMask lanes, const LaneCounts& counts, const IndexAt& at,
                      bool is_store, ShaderPhase& phase, const EndsStep& ends_step);
  template <typename IndexAt>
  void for_each_entry(std::uint64_t warp_slot, LaneMask lanes, const LaneCounts& counts, const IndexAt& at,
                      bool is_store, ShaderPhase& phase) {
    for_each_entry(warp_slot, lanes, counts, at, is_store, phase, [](std::uint32_t) { return false; });
  }
  /// A warp's access to entry index_of(lane) of the k-buffers of `lanes`: a memory instruction for each word.
  template <typename IndexOf>
  void access_k_buffer(std::uint64_t warp_slot, LaneMask lanes, const IndexOf& index_of, bool is_store,
                       ShaderPhase& phase);
  /// The same for the eviction buffers of warp slot `slot`; an entry there is a single memory access.
  template <typename IndexOf>
  void access_evictions(unsigned slot, LaneMask lanes, const IndexOf& index_of, bool is_store, ShaderPhase& phase);
  void close_steps(ShaderPhase& phase) const;
  void find_active(Warp& warp);
  void load(Region region, ShaderPhase& phase);
  void store(Region region, ShaderPhase& phase);

  const MemoryMap& map_;
  ShaderCosts costs_;
  HitHeap heap_;
  unsigned sm_;
  unsigned k_;
  bool checkpoint_;
  bool single_;  ///< header.tracing
  bool list_;
  bool closest_;  ///< header.tracing: no any-hit shader; the hit is returned in registers
  bool boxes_;
  bool sends_end_;  ///< header.opacity_bound: a call brings the opacity at which its rays end
  bool bounded_;    ///< header.opacity_bound, and shaders take the hits: entries of the k-buffer have alpha
  bool delayed_;    ///< hits wait in lists until the traversal of their round ends
  bool two_level_;
  bool colour_table_;         ///< header.colour
  unsigned sh_instructions_;  ///< of an entry's colour
  std::uint64_t gaussian_bytes_;
  std::uint64_t sh_bytes_;
  std::vector<Warp> warps_;
  std::unordered_set<std::uint32_t> coloured_;  ///< Gaussians whose colour the SM has made in frame_
  std::uint32_t frame_ = 0;
  Coalescer coalescer_;
  ShaderCounters counters_;
};

template <typename IndexAt, typename EndsStep>
void ShaderProgram::for_each_entry(std::uint64_t warp_slot, LaneMask lanes, const LaneCounts& counts, const IndexAt& at,
                                   bool is_store, ShaderPhase& phase, const EndsStep& ends_step) {
  for (std::uint32_t i = 0;; ++i) {
    LaneMask running = 0;  // lanes whose loop is longer than i
    for_each_bit(lanes, [&](unsigned lane) {
      if (counts[lane] > i) running |= bit(lane);
    });
    if (running == 0) return;
    access_k_buffer(
        warp_slot, running, [&](unsigned lane) { return at(lane, i); }, is_store, phase);
    if (ends_step(i)) phase.steps.push_back(static_cast<std::uint32_t>(phase.loads.size()));
  }
}

template <typename IndexOf>
void ShaderProgram::access_k_buffer(std::uint64_t warp_slot, LaneMask lanes, const IndexOf& index_of, bool is_store,
                                    ShaderPhase& phase) {
  constexpr std::uint64_t kFieldBytes = 4;
  if (heap_.enabled) return;  // in registers
  for (unsigned field = 0; field < map_.hit_fields(); ++field) {
    is_store ? store(Region::k_buffer, phase) : load(Region::k_buffer, phase);
    for_each_bit(lanes, [&](unsigned lane) {
      coalescer_.touch(map_.k_buffer(warp_slot, index_of(lane), field, lane), kFieldBytes);
    });
  }
}

template <typename IndexOf>
void ShaderProgram::access_evictions(unsigned slot, LaneMask lanes, const IndexOf& index_of, bool is_store,
                                     ShaderPhase& phase) {
  if (costs_.eviction_traffic == TrafficCharging::uncharged) return;
  is_store ? store(Region::eviction, phase) : load(Region::eviction, phase);
  for_each_bit(lanes, [&](unsigned lane) {
    coalescer_.touch(map_.eviction_entry(map_.ray_slot(sm_, slot, lane), index_of(lane)), map_.eviction_entry_bytes());
  });
}

}  // namespace grtx::modules
