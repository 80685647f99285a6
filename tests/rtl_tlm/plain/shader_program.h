// SPDX-License-Identifier: Apache-2.0
// What the shader phases of a plain warp load, execute and store: docs/model/simt_core.md, "What the phases do".
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <functional>
#include <set>
#include <utility>
#include <vector>

#include "grtx/modules/simt/simt_core.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"
#include "rtl_tlm/plain/address_map.h"
#include "rtl_tlm/plain/messages.h"

namespace grtx::sim::plain {

enum class PhaseKind { prologue, evict_move, trace_call, any_hit, sort, blend, epilogue, node_fetch, intersection };
inline constexpr const char* kPhaseNames[] = {"prologue", "evict_move", "trace_call", "any_hit",     "sort",
                                              "blend",    "epilogue",   "node_fetch", "intersection"};

struct Phase {
  PhaseKind kind = PhaseKind::prologue;
  std::uint64_t instructions = 0;
  std::vector<Access> loads, stores;
  unsigned load_instructions = 0, store_instructions = 0;
  /// For loads that wait for each other: where each step ends in `loads`; empty: one step.
  std::vector<std::size_t> steps;
  Cycle heap_cycles = 0;  ///< until the entries of the longest heap have been taken out
};

/// What the shaders counted of what they did.
struct ShaderCounts {
  std::uint64_t ray_rounds = 0, any_hit_calls = 0, evictions = 0, eviction_moves = 0, processed = 0, blended = 0;
  std::uint64_t k_buffer_mismatches = 0, intersections = 0;
  std::uint64_t heap_cycles = 0;  ///< of all lanes
  std::uint64_t colours = 0;      ///< made
};

/// The program of one resident warp, with what its lanes keep between phases.
class ShaderProgram {
 public:
  /// coloured: Gaussians whose colour the SM has in its table.
  ShaderProgram(const modules::SimtCoreConfig& config, const traces::Header& header, const AddressMap& map, unsigned sm,
                std::set<std::uint64_t>& coloured)
      : costs_(config.costs), heap_(config.heap), header_(header), map_(map), sm_(sm), coloured_(&coloured) {}

  void start(const traces::RayGroup& group, unsigned slot) {
    group_ = &group;
    slot_ = slot;
    lanes_.assign(group.rays.size(), {});
  }
  bool has_round(unsigned round) const {
    return std::any_of(group_->rays.begin(), group_->rays.end(),
                       [round](const traces::Ray& ray) { return round < ray.rounds.size(); });
  }

  Phase prologue() const { return {PhaseKind::prologue, costs_.raygen_prologue, {}, {}, 0, 0, {}, 0}; }
  Phase trace_call() const {
    const std::uint64_t end = header_.opacity_bound == traces::OpacityBound::on ? costs_.any_hit_bound : 0;
    return {PhaseKind::trace_call, costs_.trace_call + end, {}, {}, 0, 0, {}, 0};
  }

  /// The first phase of a round when the trace has checkpoints, and what a round begins with when it has none.
  Phase evict_move(unsigned round, ShaderCounts& counts) {
    Phase phase{PhaseKind::evict_move, costs_.evict_move_fixed, {}, {}, 0, 0, {}, 0};
    std::uint64_t most = 0;
    for_active(round, [&](unsigned l) { most = std::max(most, lanes_[l].evicted); });
    phase.instructions += costs_.evict_move_per_entry * most;
    for (std::uint64_t i = 0; i < most; ++i) {
      evictions(phase, false, [&](auto&& touch) {
        for_active(round, [&](unsigned l) {
          if (i < lanes_[l].evicted) touch(l, i);
        });
      });
    }
    const auto preloaded = [&](unsigned l) { return std::uint64_t{this->round(l, round).preloaded}; };
    for (std::uint64_t i = 0; i < header_.k; ++i) {
      k_buffer(phase, true, [&](auto&& touch) {
        for_active(round, [&](unsigned l) {
          if (i < preloaded(l)) touch(l, i);
        });
      });
    }
    for (std::uint64_t i = 0; i < most; ++i) {
      evictions(phase, true, [&](auto&& touch) {
        for_active(round, [&](unsigned l) {
          if (preloaded(l) > 0 && i + preloaded(l) < lanes_[l].evicted) touch(l, i);
        });
      });
    }
    begin_round(round, counts);
    return phase;
  }
  void begin_round(unsigned round, ShaderCounts& counts) {
    for_active(round, [&](unsigned l) {
      const std::uint64_t preloaded = this->round(l, round).preloaded;
      ++counts.ray_rounds;
      counts.eviction_moves += preloaded;
      lanes_[l].evicted -= preloaded;
      lanes_[l].filled = static_cast<std::int64_t>(preloaded);
    });
  }

  /// Boxes: each lane's ray against what lies in its box, whose matrix is read unless an instance has been entered.
  Phase intersection(const AnyHitBatch& batch, ShaderCounts& counts) {
    Phase phase{PhaseKind::intersection, call_of(batch.calls.size()) + costs_.intersection_fixed, {}, {}, 0, 0, {}, 0};
    counts.intersections += batch.calls.size();
    if (delayed()) read_list(batch.calls, phase);
    if (header_.two_level) return phase;
    phase.instructions += costs_.intersection_transform;
    Instruction matrix(phase.loads, phase.load_instructions, Region::gaussian, false);
    for (const AnyHitBatch::Call& call : batch.calls) matrix.touch(map_.shape(call.leaf), 48);
    return phase;
  }
  /// The stores of hits that fell out of a heap.
  Phase store_evicted(const AnyHitBatch& batch, ShaderCounts& counts) {
    Phase phase{PhaseKind::any_hit, 0, {}, {}, 0, 0, {}, 0};
    for (const AnyHitBatch::Call& call : batch.calls) {
      evictions(phase, true, [&](auto&& touch) { touch(call.lane, lanes_[call.lane].evicted); });
      ++lanes_[call.lane].evicted;
      ++counts.evictions;
    }
    return phase;
  }
  Phase any_hit(const AnyHitBatch& batch, ShaderCounts& counts) {
    const bool sorted = header_.tracing == traces::Tracing::multi || header_.tracing == traces::Tracing::closest;
    Phase phase = sorted ? any_hit_multi(batch, counts) : any_hit_single(batch, counts);
    if (!boxes()) phase.instructions += call_of(batch.calls.size());
    return phase;
  }

  /// Merge passes of a single-round trace; batches that a list is blended in.
  unsigned sort_passes(unsigned round) const {
    unsigned most = 0;
    if (header_.tracing == traces::Tracing::list) {
      for_active(round, [&](unsigned l) { most = std::max(most, batches(this->round(l, round).processed_count)); });
      return most;
    }
    for_active(round, [&](unsigned l) { most = std::max(most, passes(this->round(l, round).k_count)); });
    return most;
  }
  Phase sort(unsigned round, unsigned pass) const {
    Phase phase{PhaseKind::sort, 0, {}, {}, 0, 0, {}, 0};
    const bool list = header_.tracing == traces::Tracing::list;
    std::uint64_t most = 0;
    const auto entries = [&](unsigned l) -> std::uint64_t {
      const traces::Round& r = this->round(l, round);
      return pass < (list ? batches(r.processed_count) : passes(r.k_count)) ? r.k_count : 0;
    };
    for_active(round, [&](unsigned l) { most = std::max(most, entries(l)); });
    phase.instructions = costs_.sort_per_entry * most;
    if (list) phase.instructions = (costs_.list_per_entry + costs_.list_exchange * (costs_.list_batch - 1)) * most;
    for (const bool store : {false, true}) {
      if (list && store) break;  // what it finds stays in registers
      const std::uint64_t half = list ? 0 : (pass + (store ? 1 : 0)) % 2 * header_.k;
      for (std::uint64_t i = 0; i < most; ++i) {
        k_buffer(phase, store, [&](auto&& touch) {
          for_active(round, [&](unsigned l) {
            if (i < entries(l)) touch(l, half + i);
          });
        });
      }
    }
    return phase;
  }

  /// pass: of a list, how many batches have been sorted.
  Phase blend(unsigned round, unsigned pass, ShaderCounts& counts) {
    const bool list = header_.tracing == traces::Tracing::list;
    const std::uint64_t begin = list && pass > 0 ? std::uint64_t{pass - 1} * costs_.list_batch : 0;
    const std::uint64_t end = list ? begin + costs_.list_batch : ~std::uint64_t{0};
    Phase phase{PhaseKind::blend, costs_.blend_fixed, {}, {}, 0, 0, {}, 0};
    std::uint64_t most = 0;
    std::size_t active = 0;
    for_active(round, [&](unsigned l) {
      const traces::Round& r = this->round(l, round);
      ++active;
      most = std::max<std::uint64_t>(most, r.processed_count);
      if (heap_.enabled) {
        phase.heap_cycles = std::max(phase.heap_cycles, taken_out(r.processed_count));
        counts.heap_cycles += taken_out(r.processed_count);
        return;
      }
      const bool adds_up = lanes_[l].filled == static_cast<std::int64_t>(r.k_count);
      if (!adds_up && begin == 0 && header_.tracing != traces::Tracing::closest) ++counts.k_buffer_mismatches;
    });
    if (header_.tracing == traces::Tracing::closest) phase.instructions += call_of(active);
    const std::uint64_t coefficients = (header_.sh_degree + 1) * (header_.sh_degree + 1);
    // In layout quantised they are in fp16: each of three channels is converted.
    const std::uint64_t unpack = header_.layout == traces::NodeLayout::quantised ? 3 : 0;
    for (std::uint64_t i = begin; i < std::min(most, end); ++i) {
      const auto entry = [&](unsigned l) -> const traces::Processed* {
        if (i >= this->round(l, round).processed_count) return nullptr;
        return &group_->rays[l].processed[lanes_[l].processed + i];
      };
      if (header_.tracing != traces::Tracing::closest && !list) {
        k_buffer(phase, false, [&](auto&& touch) {
          for_active(round, [&](unsigned l) {
            const unsigned half =
                header_.tracing == traces::Tracing::single && passes(this->round(l, round).k_count) % 2;
            if (entry(l) != nullptr) touch(l, half * header_.k + i);
          });
        });
      }
      {
        Instruction record(phase.loads, phase.load_instructions, Region::gaussian, false);
        for_active(round, [&](unsigned l) {
          if (entry(l) == nullptr) return;
          if (!heap_.alpha && !bounded())
            record.touch(map_.gaussian(entry(l)->gaussian), header_.gaussian_record_bytes);
          ++counts.processed;
        });
      }
      bool blended = false;
      std::uint64_t colour = (costs_.sh_per_coefficient + unpack) * coefficients;
      if (header_.colour == traces::ColourPer::frame) {
        std::vector<std::uint64_t> ids;
        for_active(round, [&](unsigned l) {
          if (entry(l) != nullptr && entry(l)->blended != 0) ids.push_back(entry(l)->gaussian);
        });
        counts.blended += ids.size();
        blended = !ids.empty();
        colour = colours(phase, ids, colour, counts);
      } else {
        Instruction sh(phase.loads, phase.load_instructions, Region::sh, false);
        for_active(round, [&](unsigned l) {
          if (entry(l) == nullptr || entry(l)->blended == 0) return;
          sh.touch(map_.sh(entry(l)->gaussian), header_.sh_record_bytes);
          ++counts.blended;
          blended = true;
        });
      }
      phase.instructions +=
          (heap_.alpha || bounded() ? costs_.blend_with_alpha : costs_.blend_per_entry) + (blended ? colour : 0);
    }
    if (list && most > end) return phase;
    for_active(round, [&](unsigned l) {
      const traces::Round& r = this->round(l, round);
      lanes_[l].processed += r.processed_count;
      lanes_[l].listed = 0;
      lanes_[l].evicted -= r.eviction_dropped;
    });
    return phase;
  }

  /// The colours that a blend phase made are in the table, for all to see.
  void blend_ends() {
    coloured_->insert(making_.begin(), making_.end());
    making_.clear();
  }

  Phase epilogue() const {
    Phase phase{PhaseKind::epilogue, costs_.epilogue, {}, {}, 0, 0, {}, 0};
    Instruction store(phase.stores, phase.store_instructions, Region::ray, true);
    for (const traces::Ray& ray : group_->rays) store.touch(map_.pixel(ray.pixel), 16);
    return phase;
  }

  Phase node_fetch(const NodeFetchBatch& batch) const {
    return {PhaseKind::node_fetch, costs_.node_fetch, batch.sectors, {}, 1, 0, {}, 0};
  }

 private:
  struct Lane {
    std::int64_t filled = 0;      ///< hits that entered the k-buffer less those that left
    std::uint64_t evicted = 0;    ///< eviction buffer entries
    std::uint64_t processed = 0;  ///< entries of the rounds before
    std::uint64_t listed = 0;     ///< delayed hits of the round that have been read
  };
  /// A memory instruction of the warp: each sector that its lanes touch is asked for once, in order of first touch.
  class Instruction {
   public:
    Instruction(std::vector<Access>& out, unsigned& instructions, Region region, bool write)
        : out_(out), instructions_(instructions), first_(out.size()), region_(region), write_(write) {}
    ~Instruction() { instructions_ += touched_ ? 1 : 0; }
    Instruction(const Instruction&) = delete;
    Instruction& operator=(const Instruction&) = delete;
    void touch(std::uint64_t address, std::uint64_t bytes) {
      touched_ = true;
      for (std::uint64_t s = address / kSector; s <= (address + bytes - 1) / kSector; ++s) {
        const bool asked = std::any_of(out_.begin() + static_cast<std::ptrdiff_t>(first_), out_.end(),
                                       [s](const Access& a) { return a.address == s * kSector; });
        if (!asked) out_.push_back({s * kSector, region_, write_, false, 0, 0, 0});
      }
    }

   private:
    std::vector<Access>& out_;
    unsigned& instructions_;
    std::size_t first_;
    Region region_;
    bool write_, touched_ = false;
  };

  /// Colours of an entry from the table; those that it lacks are made, with `harmonics` instructions, and written.
  /// Returns the instructions.
  std::uint64_t colours(Phase& phase, const std::vector<std::uint64_t>& ids, std::uint64_t harmonics,
                        ShaderCounts& counts) {
    std::vector<std::uint64_t> made;
    {
      Instruction read(phase.loads, phase.load_instructions, Region::sh, false);
      for (const std::uint64_t id : ids) {
        read.touch(map_.colour(sm_, id), 8);
        if (coloured_->count(id) + making_.count(id) == 0) made.push_back(id);
      }
    }
    if (heap_.alpha || bounded()) {
      Instruction mean(phase.loads, phase.load_instructions, Region::gaussian, false);
      for (const std::uint64_t id : made) mean.touch(map_.gaussian(id), 12);
    }
    Instruction sh(phase.loads, phase.load_instructions, Region::sh, false);
    Instruction write(phase.stores, phase.store_instructions, Region::sh, true);
    for (const std::uint64_t id : made) {
      sh.touch(map_.sh(id), header_.sh_record_bytes);
      write.touch(map_.colour(sm_, id), 8);
      counts.colours += making_.insert(id).second ? 1 : 0;
    }
    return made.empty() ? 4 : 4 + 13 + harmonics;
  }

  const traces::Round& round(unsigned lane, unsigned round) const { return group_->rays[lane].rounds[round]; }
  template <typename F>
  void for_active(unsigned round, F&& f) const {
    for (unsigned l = 0; l < group_->rays.size(); ++l) {
      if (round < group_->rays[l].rounds.size()) f(l);
    }
  }
  /// An access to k-buffer entries: an instruction for t and one for id. lanes calls touch(lane, entry) for each.
  template <typename F>
  void k_buffer(Phase& phase, bool write, F&& lanes) const {
    if (heap_.enabled) return;
    for (unsigned field = 0; field < map_.words(); ++field) {
      Instruction instruction(write ? phase.stores : phase.loads,
                              write ? phase.store_instructions : phase.load_instructions, Region::k_buffer, write);
      lanes([&](unsigned lane, std::uint64_t entry) {
        instruction.touch(map_.k_buffer(sm_, slot_, entry, field, lane), 4);
      });
    }
  }
  template <typename F>
  void evictions(Phase& phase, bool write, F&& lanes) const {
    if (costs_.eviction_traffic == modules::TrafficCharging::uncharged) return;
    Instruction instruction(write ? phase.stores : phase.loads,
                            write ? phase.store_instructions : phase.load_instructions, Region::eviction, write);
    lanes([&](unsigned lane, std::uint64_t entry) {
      instruction.touch(map_.eviction(sm_, slot_, lane, entry), map_.evicted_bytes());
    });
  }
  /// Cycles in which a heap of so many entries is emptied: each time the last entry takes the first one's place.
  Cycle taken_out(unsigned entries) const {
    Cycle cycles = 0;
    for (; entries > 0; --entries) {
      cycles += heap_.latency;
      for (unsigned below = entries; below > 0; below /= 2) cycles += heap_.level_latency;
    }
    return cycles;
  }
  /// Shaders take the hits, and add up their opacities.
  bool bounded() const { return header_.opacity_bound == traces::OpacityBound::on && !heap_.enabled; }
  bool delayed() const { return header_.any_hit == traces::AnyHit::delayed && !heap_.enabled; }
  bool boxes() const { return header_.accel == traces::AccelKind::box || header_.accel == traces::AccelKind::tlas_box; }
  /// Out of the traversal and back, for a shader of so many lanes.
  std::uint64_t call_of(std::size_t lanes) const { return costs_.call_fixed + costs_.call_per_lane * lanes; }
  /// Each call's hit is the next of its lane's list in memory, which the RT unit has written.
  void read_list(const std::vector<AnyHitBatch::Call>& calls, Phase& phase) {
    for (const bool write : {true, false}) {
      evictions(phase, write, [&](auto&& touch) {
        for (const AnyHitBatch::Call& call : calls) touch(call.lane, lanes_[call.lane].listed);
      });
    }
    for (const AnyHitBatch::Call& call : calls) ++lanes_[call.lane].listed;
  }
  unsigned batches(unsigned processed) const { return (processed + costs_.list_batch - 1) / costs_.list_batch; }
  static unsigned passes(unsigned n) { return n < 2 ? 0 : static_cast<unsigned>(std::bit_width(n - 1)); }

  /// Entries that each call reads and writes, iteration by iteration over all lanes.
  struct Walk {
    unsigned lane;
    std::vector<std::uint64_t> reads, writes;
    bool evicts;
    bool enters = false;
    unsigned hidden = 0;
    std::uint64_t leaf = 0;
  };
  /// step_ends: whether a step of loads ends behind an iteration.
  template <typename F>
  Phase insertion(std::uint64_t shifts, const std::vector<Walk>& walks, ShaderCounts& counts, F&& step_ends) {
    Phase phase{PhaseKind::any_hit, costs_.any_hit_fixed + costs_.any_hit_per_shift * shifts, {}, {}, 0, 0, {}, 0};
    if (delayed() && !boxes()) {
      std::vector<AnyHitBatch::Call> calls;
      for (const Walk& w : walks) calls.push_back({w.lane, {}, 0, 0});
      read_list(calls, phase);
    }
    if (bounded()) bound(shifts, walks, phase);
    for (const bool store : {false, true}) {
      std::size_t most = 0;
      for (const Walk& w : walks) most = std::max(most, store ? w.writes.size() : w.reads.size());
      for (std::size_t i = 0; i < most; ++i) {
        k_buffer(phase, store, [&](auto&& touch) {
          for (const Walk& w : walks) {
            const auto& entries = store ? w.writes : w.reads;
            if (i < entries.size()) touch(w.lane, entries[i]);
          }
        });
        if (!store && (i + 1 == most || step_ends(i))) phase.steps.push_back(phase.loads.size());
      }
    }
    evictions(phase, true, [&](auto&& touch) {
      for (const Walk& w : walks) {
        if (w.evicts) touch(w.lane, lanes_[w.lane].evicted);
      }
    });
    for (const Walk& w : walks) {
      lanes_[w.lane].evicted += w.evicts ? 1 : 0;
      counts.evictions += w.evicts ? 1 : 0;
    }
    counts.any_hit_calls += walks.size();
    return phase;
  }
  /// Hits that enter need their alpha, which the Gaussian's record gives; all words of entries are moved.
  void bound(std::uint64_t shifts, const std::vector<Walk>& walks, Phase& phase) {
    phase.instructions += shifts;
    Instruction record(phase.loads, phase.load_instructions, Region::gaussian, false);
    bool enters = false;
    std::uint64_t hidden = 0;
    for (const Walk& w : walks) {
      if (!w.enters) continue;
      enters = true;
      hidden = std::max<std::uint64_t>(hidden, w.hidden);
      record.touch(map_.record_of_hit(w.leaf), header_.gaussian_record_bytes);
    }
    if (enters)
      phase.instructions += costs_.blend_per_entry - costs_.blend_with_alpha + costs_.any_hit_bound * (1 + hidden);
  }
  Phase any_hit_multi(const AnyHitBatch& batch, ShaderCounts& counts) {
    using traces::LeafOutcome;
    std::vector<Walk> walks;
    std::uint64_t most_shifts = 0;
    for (const AnyHitBatch::Call& call : batch.calls) {
      Lane& lane = lanes_[call.lane];
      const auto f = static_cast<std::uint64_t>(std::clamp<std::int64_t>(lane.filled, 0, header_.k));
      const std::uint64_t s = call.shifts, after = std::min<std::uint64_t>(f + 1, header_.k);
      most_shifts = std::max(most_shifts, s);
      Walk walk{call.lane, {}, {}, false};
      const bool enters = call.outcome == LeafOutcome::inserted || call.outcome == LeafOutcome::displaced;
      const std::uint64_t reads = std::min(enters ? s + 1 + (f + 1 - after) : s + 1, f);
      for (std::uint64_t i = 0; i < reads; ++i) walk.reads.push_back(f - 1 - i);
      if (enters) {
        for (std::uint64_t i = 0; i < std::min(s + 1, after); ++i) walk.writes.push_back(after - 1 - i);
        lane.filled += (call.outcome == LeafOutcome::inserted ? 1 : 0) - static_cast<std::int64_t>(call.hidden);
        walk.enters = true;
        walk.hidden = call.hidden;
        walk.leaf = call.leaf;
      }
      walk.evicts =
          header_.checkpoint && (call.outcome == LeafOutcome::displaced || call.outcome == LeafOutcome::rejected);
      walks.push_back(walk);
    }
    return insertion(most_shifts, walks, counts, [](std::size_t) { return true; });
  }
  Phase any_hit_single(const AnyHitBatch& batch, ShaderCounts& counts) {
    using traces::LeafOutcome;
    std::vector<Walk> walks;
    std::uint64_t most_shifts = 0;
    std::size_t sinks = 0;  ///< reads of the displacing lane that reads most
    for (const AnyHitBatch::Call& call : batch.calls) {
      Lane& lane = lanes_[call.lane];
      const auto f = static_cast<std::uint64_t>(lane.filled);
      const std::uint64_t s = call.shifts, k = header_.k;
      std::uint64_t shifts = s;
      Walk walk{call.lane, {}, {}, false};
      if (call.outcome == LeafOutcome::inserted && f + 1 < k) {
        walk.writes = {f};
        lane.filled = static_cast<std::int64_t>(f + 1);
      } else if (call.outcome == LeafOutcome::inserted) {  // a heap is made of the full buffer
        for (std::uint64_t i = 0; i + 1 < k; ++i) walk.reads.push_back(i);
        walk.writes.push_back(f);
        for (std::uint64_t i = 0; i < s; ++i) walk.writes.push_back(i);
        shifts = std::max(s, k / 2);
        lane.filled = static_cast<std::int64_t>(k);
      } else if (call.outcome == LeafOutcome::displaced) {
        // Down the leftmost path; what would lie behind the last entry is the last entry.
        walk.reads = {0};
        for (std::uint64_t level = 0; level <= s; ++level) {
          const std::uint64_t node = (std::uint64_t{1} << level) - 1;
          walk.writes.push_back(std::min(node, k - 1));
          for (const std::uint64_t child : {2 * node + 1, 2 * node + 2}) {
            if (walk.reads.size() < f) walk.reads.push_back(std::min(child, k - 1));
          }
        }
        sinks = std::max(sinks, walk.reads.size());
      } else if (f > 0) {  // a tie with what the last round blended may come to an empty buffer
        walk.reads = {0};
      }
      most_shifts = std::max(most_shifts, shifts);
      walks.push_back(walk);
    }
    // A level of the heap is a step: the root, then pairs of children.
    return insertion(most_shifts, walks, counts, [sinks](std::size_t i) { return i + 1 < sinks && i % 2 == 0; });
  }

  modules::ShaderCosts costs_;
  modules::HitHeap heap_;
  const traces::Header& header_;
  const AddressMap& map_;
  unsigned sm_, slot_ = 0;
  const traces::RayGroup* group_ = nullptr;
  std::vector<Lane> lanes_;
  std::set<std::uint64_t>* coloured_;
  std::set<std::uint64_t> making_;  ///< colours that its blend phase makes
};

}  // namespace grtx::sim::plain
